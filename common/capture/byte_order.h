#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace padr::capture {

using ByteView = std::span<const std::byte>;

/// Unsigned numbers out of bytes that are there: the caller has checked.
inline std::uint32_t u8(ByteView b, std::size_t at) {
  return std::to_integer<std::uint32_t>(b[at]);
}
inline std::uint32_t be16(ByteView b, std::size_t at) {
  return u8(b, at) << 8U | u8(b, at + 1);
}
inline std::uint32_t be32(ByteView b, std::size_t at) {
  return be16(b, at) << 16U | be16(b, at + 2);
}
inline std::uint32_t le16(ByteView b, std::size_t at) {
  return u8(b, at) | u8(b, at + 1) << 8U;
}
inline std::uint32_t le32(ByteView b, std::size_t at) {
  return le16(b, at) | le16(b, at + 2) << 16U;
}

/// The byte order that a file was written in.
struct ByteOrder {
  bool big = false;
  std::uint32_t u16(ByteView b, std::size_t at) const { return big ? be16(b, at) : le16(b, at); }
  std::uint32_t u32(ByteView b, std::size_t at) const { return big ? be32(b, at) : le32(b, at); }
};

}  // namespace padr::capture
