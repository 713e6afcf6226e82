#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace padr::lab::alternatives {

/// Writes whole numbers of any width one after the other, lowest bit first.
class BitWriter {
 public:
  /// The lowest `width` bits of `value`; 0 .. 32.
  void put(std::uint32_t value, int width);
  void flag(bool b) { put(b ? 1 : 0, 1); }
  /// Two's complement in `width` bits: value in -2^(width-1) .. 2^(width-1) - 1.
  void put_signed(std::int32_t value, int width) { put(static_cast<std::uint32_t>(value), width); }
  /// Few bits for small numbers: groups of three, each with a bit that says whether another one follows.
  void put_small(std::uint32_t value);
  /// All 32 bits of an IEEE 754 number.
  void put_float(float value);

  /// All bits of another writer.
  void append(const BitWriter& other);

  std::size_t bits() const { return bits_; }
  /// Padded with zeros to whole bytes.
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t bits_ = 0;
};

/// Reads what BitWriter wrote. Beyond the end everything is 0 and ok() is false from then on.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint32_t get(int width);
  bool flag() { return get(1) != 0; }
  std::int32_t get_signed(int width);
  std::uint32_t get_small();
  float get_float();

  bool ok() const { return ok_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Bits that numbers 0 .. n need, n >= 1.
int width_of(std::uint32_t n);

}  // namespace padr::lab::alternatives
