// Gives libFuzzer a good input now and then instead of a mutation of what it has.
#include <algorithm>

#include "tests/fuzz/good.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  padr::Rng rng(seed);
  if (size > 1 && !rng.chance(1.0 / 32)) return LLVMFuzzerMutate(data, size, max_size);
  const padr::wire::Bytes good = padr::test::good_input(rng);
  const std::size_t n = std::min(good.size(), max_size);
  std::transform(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n), data,
                 [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
  return n;
}
