#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/model/vec.h"

namespace padr::scenarios {

struct PathPoint {
  double seconds = 0;  ///< as written in the file; only differences matter
  Vec2 position;       ///< m
  friend bool operator==(const PathPoint&, const PathPoint&) = default;
};

/// A recorded motion: where a pointer or a player was when.
class Path {
 public:
  /// At least two points, strictly increasing in time, all finite: ours to guarantee (parse_path_csv does for files).
  explicit Path(std::vector<PathPoint> points);

  /// Where the path is `seconds` after its first point, m: on the straight line between the two points about it.
  /// Before the start it is the first point. After the end it is the last one, or, with `loop`, the path starts again
  /// at once (its end and beginning need not meet). `seconds` must be a number.
  Vec2 at(double seconds, bool loop) const;
  /// Seconds from the first point to the last: more than 0.
  double duration() const;
  const std::vector<PathPoint>& points() const { return points_; }

 private:
  std::vector<PathPoint> points_;
};

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
Path parse_path_csv(std::string_view text, std::string_view label, const PathUnits& units = {});

/// The path as CSV that parse_path_csv reads back to the same path, to the bit.
std::string write_path_csv(const Path& path);

}  // namespace padr::scenarios
