// Prints the physics fingerprint of what it is linked with.
#include <cstdio>

#include "common/world/fingerprint.h"

int main() {
  std::puts(padr::world::fingerprint_text(padr::world::physics_fingerprint()).c_str());
}
