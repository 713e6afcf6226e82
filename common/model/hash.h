#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace padr {

/// 16 lower-case hexadecimal digits, as people see hashes.
inline std::string hex(std::uint64_t v) {
  std::string text(16, '0');
  for (std::size_t i = text.size(); i-- > 0; v >>= 4U) text[i] = "0123456789abcdef"[v & 15U];
  return text;
}

/// Order-dependent 64-bit hash over exact bits, for comparing states and definitions between peers.
/// Not cryptographic: it finds differences, it does not resist an attacker.
class Hasher {
 public:
  void add(std::uint64_t v) {
    h_ = (h_ ^ v) * 0x9FB21C651E98DF25ULL;
    h_ ^= h_ >> 35U;
  }
  /// +0 and -0 hash alike: they play out alike, and which one a sum yields says nothing.
  void add(float v) { add(word(0, v)); }
  /// Two numbers for the price of one.
  void add(float a, float b) { add(word(a, b)); }
  static std::uint64_t word(float a, float b) { return bits(a) << 32U | bits(b); }
  void add(std::string_view s) {
    add(static_cast<std::uint64_t>(s.size()));
    for (const char c : s) add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  }
  std::uint64_t value() const {
    std::uint64_t h = h_ * 0x9FB21C651E98DF25ULL;
    return h ^ (h >> 28U);
  }

 private:
  static std::uint64_t bits(float v) { return std::bit_cast<std::uint32_t>(v + 0.0F); }

  std::uint64_t h_ = 0xCBF29CE484222325ULL;
};

/// As Hasher, for whole states: four words at a time, each into a hash of its own. A multiplication has to wait for the
/// one before it, so four of them side by side take little longer than one.
class WideHasher {
 public:
  void add(std::uint64_t a, std::uint64_t b, std::uint64_t c, std::uint64_t d) {
    lanes_[0].add(a);
    lanes_[1].add(b);
    lanes_[2].add(c);
    lanes_[3].add(d);
  }
  std::uint64_t value() const {
    Hasher all;
    for (const Hasher& lane : lanes_) all.add(lane.value());
    return all.value();
  }

 private:
  std::array<Hasher, 4> lanes_;
};

}  // namespace padr
