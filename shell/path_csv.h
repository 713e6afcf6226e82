#pragma once

#include <string>
#include <string_view>

#include "common/scenarios/path.h"

namespace padr::shell {

/// What the numbers of a file count in.
struct PathUnits {
  double per_second = 1;  ///< time units
  std::string_view time = "s";
  std::string_view length = "m";  ///< positions are not converted
  bool merge = false;             ///< of rows with the same t the last one counts; otherwise they are an error
};

/// Reads CSV with the columns t,x,y (seconds, metres, metres; t strictly increasing, at least two rows). A first line
/// `t,x,y` is skipped, as are blank lines and lines that begin with `#`; CRLF, a byte order mark and blanks round the
/// numbers are tolerated. With other `units` times are turned into seconds. Throws UserError "label:line:column: what
/// is wrong, allowed: what would be right".
scenarios::Path parse_path_csv(std::string_view text, std::string_view label, const PathUnits& units = {});

/// The path as CSV that parse_path_csv reads back to the same path, to the bit.
std::string write_path_csv(const scenarios::Path& path);

}  // namespace padr::shell
