// Prints the physics fingerprint of what it is linked with.
#include <cstdio>

#include "common/model/hash.h"
#include "common/world/fingerprint.h"

int main() {
  std::puts(padr::hex(padr::world::physics_fingerprint()).c_str());
}
