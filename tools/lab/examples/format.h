#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace padr::lab::examples {

/// printf into a string of at most 499 characters: a line of a table.
template <typename... Args>
std::string format(const char* pattern, Args... args) {
  std::array<char, 500> text{};
  const int n = std::snprintf(text.data(), text.size(), pattern, args...);
  return {text.data(), static_cast<std::size_t>(n)};
}

}  // namespace padr::lab::examples
