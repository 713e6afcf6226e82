#pragma once

#include <span>
#include <string_view>

namespace padr::scenarios {

/// A scenario file of this folder, or a path of its folder `paths`, built in by embed.cmake.
struct Embedded {
  std::string_view name;  ///< file name without its ending
  std::string_view text;
};

/// The scenarios, sorted by name.
std::span<const Embedded> embedded();
/// The paths of the paper's stories (CSV, see path.h), sorted by name: a path is named after its scenario.
std::span<const Embedded> embedded_paths();

}  // namespace padr::scenarios
