// Stands in for libFuzzer where it is not: a bounded number of seeded random inputs.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/model/rng.h"
#include "tests/seed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main() {
  padr::Rng rng(padr::test::seed());
  std::vector<std::uint8_t> input;
  for (int i = 0; i < 2000; ++i) {
    input.resize(rng.below(300));
    for (auto& byte : input) byte = static_cast<std::uint8_t>(rng.below(256));
    LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  return 0;
}
