#pragma once

#include <span>
#include <string_view>

namespace padr::scenarios {

/// A scenario file of this folder, built in by embed.cmake.
struct Embedded {
  std::string_view name;  ///< file name without .textproto
  std::string_view text;
};

/// Sorted by name.
std::span<const Embedded> embedded();

}  // namespace padr::scenarios
