#include "tools/lab/measure/jumps.h"

#include <algorithm>

namespace padr::lab {
namespace {

constexpr float kJump = 0.03F;  // m, as sync::Shown counts

}  // namespace

void JumpMeter::tick(const std::vector<Vec2>& shown, const std::vector<Vec2>& velocity) {
  const bool first = before_.size() != shown.size();
  if (first) {
    before_ = shown;
    stride_.assign(shown.size(), {});
    return;
  }
  for (std::size_t e = 0; e < shown.size(); ++e) {
    const Vec2 moved = shown[e] - before_[e];
    const Vec2 straight = velocity[e] * kTickSeconds;
    before_[e] = shown[e];
    const float beyond = distance_to_segment(moved, stride_[e], straight);
    // After a jump it goes on as it should, not as it jumped.
    stride_[e] = beyond > kJump ? straight : moved;
    if (beyond <= kJump) continue;
    ++jumps_;
    metres_ += static_cast<double>(beyond);
    largest_m_ = std::max(largest_m_, static_cast<double>(beyond));
  }
}

}  // namespace padr::lab
