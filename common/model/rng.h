#pragma once

#include <array>
#include <cstdint>

namespace padr {

/// One step of SplitMix64 (Steele, Lea, Flood 2014): advances `state` and returns a well mixed value.
constexpr std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

/// A seed for an independent stream out of a seed and up to two numbers that name the stream.
constexpr std::uint64_t derive_seed(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0) {
  std::uint64_t s = seed;
  std::uint64_t h = splitmix64(s) ^ (a * 0xD6E8FEB86659FD93ULL);
  h = splitmix64(h) ^ (b * 0xA0761D6478BD642FULL);
  return splitmix64(h);
}

/// xoshiro256** (Blackman, Vigna 2018): small, fast, the same on every machine. Always seeded by the caller.
class Rng {
 public:
  explicit constexpr Rng(std::uint64_t seed) {
    for (auto& word : s_) word = splitmix64(seed);
  }

  constexpr std::uint64_t next_u64() {
    const std::uint64_t result = rotl(s_[1] * 5, 7) * 9;
    const std::uint64_t t = s_[1] << 17U;
    s_[2] ^= s_[0];
    s_[3] ^= s_[1];
    s_[1] ^= s_[2];
    s_[0] ^= s_[3];
    s_[2] ^= t;
    s_[3] = rotl(s_[3], 45);
    return result;
  }
  constexpr std::uint32_t next_u32() { return static_cast<std::uint32_t>(next_u64() >> 32U); }
  /// In [0, 1).
  constexpr double uniform() { return static_cast<double>(next_u64() >> 11U) * 0x1.0p-53; }
  /// In [lo, hi).
  constexpr double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  /// In [0, n); n > 0. The bias of the multiply method is below 2^-32 for the small n used here.
  constexpr std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next_u32()) * n) >> 32U);
  }
  /// True with probability p: never for 0, always for 1.
  constexpr bool chance(double p) { return uniform() < p; }

 private:
  static constexpr std::uint64_t rotl(std::uint64_t x, int k) {
    return (x << static_cast<unsigned>(k)) | (x >> static_cast<unsigned>(64 - k));
  }
  std::array<std::uint64_t, 4> s_{};
};

}  // namespace padr
