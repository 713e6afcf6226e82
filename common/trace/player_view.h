#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "common/model/state.h"

namespace padr::trace {

/// What one player has at one tick; a trace holds no less.
struct PlayerView {
  bool there = false;               ///< its avatar is a part of the session
  std::span<const BodyState> live;  ///< of its live world, by entity id
  Vec2 target;                      ///< m, what its avatar was driven towards in the step that led here
};

/// Whether Box2D can step such a world: a damaged trace may hold anything.
inline bool can_be_stepped(const PlayerView& v) {
  constexpr float kFar = 1e5F;   // m
  constexpr float kFast = 1e4F;  // m/s, rad/s
  const auto is_below = [](float x, float most) { return std::abs(x) < most; };
  const auto is_near = [&](Vec2 at) { return is_below(at.x, kFar) && is_below(at.y, kFar); };
  return is_near(v.target) && std::all_of(v.live.begin(), v.live.end(), [&](const BodyState& s) {
           return is_near(s.position) && is_below(s.angle, kFar) && is_below(s.velocity.x, kFast) &&
                  is_below(s.velocity.y, kFast) && is_below(s.spin, kFast);
         });
}

}  // namespace padr::trace
