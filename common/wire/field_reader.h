#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace padr::wire {

/// Walks through the fields of a protobuf message without making an object of it, as proto/WIRE.md, section 2, has it:
///
///   for (FieldReader f(message); f.next();) ...
///   and afterwards ok() tells whether the message was well formed to its end.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::byte> message) : rest_(message) {}

  /// The next field; groups are stepped over. False at the end and at what is malformed.
  bool next() {
    while (ok_ && !rest_.empty()) {
      if (!read_key()) return fail();
      if (type != 3) return read_value(type) || fail();
      if (!skip_group(number, 0)) return fail();
    }
    return false;
  }
  bool ok() const { return ok_; }

  std::uint32_t number = 0;
  std::uint32_t type = 0;            ///< 0 varint, 1 eight bytes, 2 bytes, 5 four bytes
  std::uint64_t value = 0;           ///< of the types 0, 1 and 5
  std::span<const std::byte> bytes;  ///< of type 2

  std::uint32_t u32() const { return static_cast<std::uint32_t>(value); }

  /// Takes a varint of at most `most` bytes off the begin of `b`; false if there is none.
  static bool varint(std::span<const std::byte>& b, std::uint64_t& out, std::size_t most = 10) {
    out = 0;
    for (std::size_t i = 0; i < most && i < b.size(); ++i) {
      const auto byte = std::to_integer<std::uint64_t>(b[i]);
      out |= (byte & 0x7FU) << (7 * i);
      if (byte < 0x80) {
        b = b.subspan(i + 1);
        return true;
      }
    }
    return false;
  }

 private:
  static constexpr int kMostDepth = 100;

  bool fail() {
    ok_ = false;
    return false;
  }
  bool read_key() {
    std::uint64_t key = 0;
    if (!varint(rest_, key, 5)) return false;
    number = static_cast<std::uint32_t>(key) >> 3U;
    type = key & 7U;
    return number != 0;
  }
  bool read_fixed(std::size_t n) {
    if (rest_.size() < n) return false;
    value = 0;
    for (std::size_t i = 0; i < n; ++i) value |= std::to_integer<std::uint64_t>(rest_[i]) << (8 * i);
    rest_ = rest_.subspan(n);
    return true;
  }
  bool read_value(std::uint32_t of_type) {
    switch (of_type) {
      case 0:
        return varint(rest_, value);
      case 1:
        return read_fixed(8);
      case 5:
        return read_fixed(4);
      case 2: {
        std::uint64_t length = 0;
        if (!varint(rest_, length, 5)) return false;
        length &= 0xFFFFFFFFU;
        if (length > rest_.size()) return false;
        bytes = rest_.first(length);
        rest_ = rest_.subspan(length);
        return true;
      }
      default:
        return false;
    }
  }
  bool skip_group(std::uint32_t of, int depth) {
    while (depth < kMostDepth && !rest_.empty() && read_key()) {
      if (type == 4) return number == of;
      if (!(type == 3 ? skip_group(number, depth + 1) : read_value(type))) return false;
    }
    return false;
  }

  std::span<const std::byte> rest_;
  bool ok_ = true;
};

}  // namespace padr::wire
