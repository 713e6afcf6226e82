#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace padr::test {

inline std::span<const std::byte> bytes(const std::uint8_t* data, std::size_t size) {
  return std::as_bytes(std::span(data, size));
}
inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace padr::test
