#include "common/scenarios/path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace padr::scenarios {

Path::Path(std::vector<PathPoint> points) : points_(std::move(points)) {
  assert(points_.size() >= 2);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    assert(std::isfinite(points_[i].seconds) && is_finite(points_[i].position));
    assert(i == 0 || points_[i].seconds > points_[i - 1].seconds);
  }
}

Vec2 Path::at(double seconds, bool loop) const {
  assert(!std::isnan(seconds));
  if (seconds <= 0) return points_.front().position;
  if (loop && std::isfinite(seconds)) seconds = std::fmod(seconds, duration());
  const double t = points_.front().seconds + seconds;
  const auto next = std::upper_bound(points_.begin(), points_.end(), t,
                                     [](double value, const PathPoint& p) { return value < p.seconds; });
  if (next == points_.end()) return points_.back().position;
  const PathPoint& a = *std::prev(next);
  const PathPoint& b = *next;
  const double part = (t - a.seconds) / (b.seconds - a.seconds);
  const auto between = [part](float from, float to) {
    const double start = from;
    return static_cast<float>(start + (static_cast<double>(to) - start) * part);
  };
  return {between(a.position.x, b.position.x), between(a.position.y, b.position.y)};
}

double Path::duration() const {
  return points_.back().seconds - points_.front().seconds;
}

}  // namespace padr::scenarios
