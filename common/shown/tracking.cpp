#include "common/shown/tracking.h"

#include <algorithm>
#include <cmath>

namespace padr::sync {

Vec2 believable_stride(Vec2 want, Vec2 last, Vec2 straight) {
  const Vec2 nearest = nearest_on_segment(want, last, straight);
  return nearest + clamp_length(want - nearest, kMostChange);
}

// Braked by a = kMostChange a tick, steps of v, v - a, ... down to the n-th make up for n v - a n (n - 1) / 2. The
// fewest steps whose fastest sequence, a n (n + 1) / 2, reaches the offset; then v follows.
Vec2 fastest_glide(Vec2 offset) {
  const float d = length(offset);
  if (d == 0) return {};
  const float n = std::max(1.0F, std::ceil((std::sqrt(1 + 8 * d / kMostChange) - 1) / 2));
  const float speed = d / n + kMostChange * (n - 1) / 2;
  return offset * (-speed / d);
}

}  // namespace padr::sync
