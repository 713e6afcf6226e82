#include "tools/lab/alternatives/bits.h"

#include <bit>
#include <cassert>

namespace padr::lab::alternatives {
namespace {

constexpr int kGroup = 3;
constexpr int kGroups = 11;  // 33 bits

}  // namespace

void BitWriter::put(std::uint32_t value, int width) {
  assert(width >= 0 && width <= 32);
  for (int i = 0; i < width; ++i, ++bits_) {
    if (bits_ % 8 == 0) bytes_.push_back(std::byte{0});
    if (((value >> static_cast<unsigned>(i)) & 1U) != 0) bytes_.back() |= std::byte{1} << (bits_ % 8);
  }
}

void BitWriter::put_small(std::uint32_t value) {
  do {
    put(value & 7U, kGroup);
    value >>= static_cast<unsigned>(kGroup);
    flag(value != 0);
  } while (value != 0);
}

void BitWriter::put_float(float value) {
  put(std::bit_cast<std::uint32_t>(value), 32);
}

void BitWriter::append(const BitWriter& other) {
  BitReader r(other.bytes_);
  for (std::size_t i = 0; i < other.bits_; ++i) flag(r.flag());
}

std::uint32_t BitReader::get(int width) {
  std::uint32_t value = 0;
  for (int i = 0; i < width; ++i, ++at_) {
    if (at_ / 8 >= bytes_.size()) {
      ok_ = false;
      return 0;
    }
    const auto bit = (std::to_integer<std::uint32_t>(bytes_[at_ / 8]) >> (at_ % 8)) & 1U;
    value |= bit << static_cast<unsigned>(i);
  }
  return value;
}

std::int32_t BitReader::get_signed(int width) {
  const std::uint32_t value = get(width);
  const std::uint32_t sign = 1U << static_cast<unsigned>(width - 1);
  return static_cast<std::int32_t>((value ^ sign) - sign);
}

std::uint32_t BitReader::get_small() {
  std::uint32_t value = 0;
  for (int g = 0; g < kGroups; ++g) {
    value |= get(kGroup) << static_cast<unsigned>(g * kGroup);
    if (!flag()) return value;
  }
  ok_ = false;
  return 0;
}

float BitReader::get_float() {
  return std::bit_cast<float>(get(32));
}

int width_of(std::uint32_t n) {
  return static_cast<int>(std::bit_width(n));
}

}  // namespace padr::lab::alternatives
