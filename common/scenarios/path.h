#pragma once

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
  /// At least two points, strictly increasing in time, all finite: who makes it guarantees that.
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

}  // namespace padr::scenarios
