#include "tools/monitor/series.h"

namespace padr::monitor {
namespace {

constexpr Tick kMinute = 60 * kTicksPerSecond;
constexpr std::size_t kEvery = 64;  // points between two times of thinning

/// The least distance in ticks between two points of this age; below 0: the points are removed.
Tick spacing(Tick age) {
  if (age > 60 * kMinute) return -1;
  if (age > 20 * kMinute) return 4 * kTicksPerSecond;
  return age > 5 * kMinute ? kTicksPerSecond : 0;
}

}  // namespace

void Series::add(SeriesPoint p) {
  const Tick now = p.tick;
  points_.push_back(std::move(p));
  if (++added_ % kEvery == 0) thin(now);
}

void Series::thin(Tick now) {
  std::deque<SeriesPoint> kept;
  for (SeriesPoint& p : points_) {
    const Tick least = spacing(now - p.tick);
    if (least < 0 || (!kept.empty() && p.tick - kept.back().tick < least)) continue;
    kept.push_back(std::move(p));
  }
  points_ = std::move(kept);
}

}  // namespace padr::monitor
