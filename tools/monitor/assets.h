#pragma once

#include <span>
#include <string_view>

namespace padr::monitor {

/// A file of the page, built into the program.
struct Asset {
  std::string_view path;  ///< as asked for, such as /index.html
  std::string_view type;  ///< MIME
  std::string_view etag;  ///< with its quotes
  std::string_view body;
};

std::span<const Asset> assets();

}  // namespace padr::monitor
