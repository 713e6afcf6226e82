#pragma once

#include <string>
#include <string_view>

namespace padr::report {

/// `text` with every byte that is not part of well-formed UTF-8 (RFC 3629) replaced by U+FFFD: JSON allows nothing
/// else, and command lines and paths may hold any bytes.
std::string valid_utf8(std::string_view text);

}  // namespace padr::report
