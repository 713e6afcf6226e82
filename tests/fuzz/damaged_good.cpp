// Stands in for libFuzzer where it is not: a bounded number of seeded good inputs, each as it is, then damaged. With
// files as arguments it tries those, as libFuzzer does.
//
// PADR_FUZZ_GOOD=N in the environment: so many good inputs. PADR_FUZZ_LAST=FILE: the input that is being tried is kept
// there, so that it is known when the program aborts.
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/good.h"
#include "tests/seed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

void damage(padr::Rng& rng, Input& input) {
  if (rng.chance(0.1)) input.resize(rng.below(static_cast<std::uint32_t>(input.size()) + 1));
  for (std::uint32_t n = 1 + rng.below(4); n > 0 && !input.empty(); --n) {
    std::uint8_t& byte = input[rng.below(static_cast<std::uint32_t>(input.size()))];
    byte = static_cast<std::uint8_t>(rng.chance(0.5) ? rng.below(256) : byte ^ (1U << rng.below(8)));
  }
}

void run(const Input& input) {
  if (const char* last = std::getenv("PADR_FUZZ_LAST"))
    std::ofstream(last, std::ios::binary).write(reinterpret_cast<const char*>(input.data()), std::ssize(input));
  LLVMFuzzerTestOneInput(input.data(), input.size());
}

int good_inputs() {
  const char* text = std::getenv("PADR_FUZZ_GOOD");
  return text != nullptr ? std::stoi(text) : padr::test::kGoodInputs;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kDamagedEach = 8;
  if (argc > 1) {
    for (int i = 1; i < argc; ++i) {
      std::ifstream file(argv[i], std::ios::binary);
      run({std::istreambuf_iterator<char>(file), {}});
    }
    return 0;
  }
  padr::Rng rng(padr::test::seed());
  for (int i = good_inputs(); i > 0; --i) {
    Input input;
    for (const std::byte b : padr::test::good_input(rng)) input.push_back(std::to_integer<std::uint8_t>(b));
    run(input);
    for (int k = 0; k < kDamagedEach; ++k) {
      Input damaged = input;
      damage(rng, damaged);
      run(damaged);
    }
  }
}
