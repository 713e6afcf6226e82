// Stands in for libFuzzer where it is not: a bounded number of seeded good inputs, each as it is, then damaged.
#include <vector>

#include "tests/fuzz/good.h"
#include "tests/seed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void damage(padr::Rng& rng, std::vector<std::uint8_t>& input) {
  if (rng.chance(0.1)) input.resize(rng.below(static_cast<std::uint32_t>(input.size()) + 1));
  for (std::uint32_t n = 1 + rng.below(4); n > 0 && !input.empty(); --n) {
    std::uint8_t& byte = input[rng.below(static_cast<std::uint32_t>(input.size()))];
    byte = static_cast<std::uint8_t>(rng.chance(0.5) ? rng.below(256) : byte ^ (1U << rng.below(8)));
  }
}

}  // namespace

int main() {
  constexpr int kGood = 150;
  constexpr int kDamagedEach = 8;
  padr::Rng rng(padr::test::seed());
  for (int i = 0; i < kGood; ++i) {
    const padr::wire::Bytes good = padr::test::good_input(rng);
    std::vector<std::uint8_t> input;
    for (const std::byte b : good) input.push_back(std::to_integer<std::uint8_t>(b));
    LLVMFuzzerTestOneInput(input.data(), input.size());
    for (int k = 0; k < kDamagedEach; ++k) {
      std::vector<std::uint8_t> damaged = input;
      damage(rng, damaged);
      LLVMFuzzerTestOneInput(damaged.data(), damaged.size());
    }
  }
}
