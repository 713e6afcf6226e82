#pragma once

#include <cmath>
#include <cstdint>

#include "common/model/state.h"

namespace padr {

// States may be told rounded: in whole steps, which the wire tells in fewer bytes than floats. Steps are powers of two,
// and so few of them make a value that it is exact as a float.

inline constexpr float kPlaceStep = 1.0F / (1 << 14);   ///< m of positions and targets, rad of angles
inline constexpr float kMotionStep = 1.0F / (1 << 12);  ///< m/s, rad/s, m/s^2
/// Of values that can be told in steps, either way.
inline constexpr std::int32_t kMostSteps = (1 << 24) - 1;

/// Whether the value is a whole number of steps that can be told; not of -0, which is another float than 0.
inline bool in_steps(float v, float step) {
  const float n = v / step;
  if (!(std::abs(n) <= static_cast<float>(kMostSteps))) return false;
  if (n == 0) return !std::signbit(n);
  return static_cast<float>(static_cast<std::int32_t>(n)) == n;
}

/// If in_steps.
inline std::int32_t to_steps(float v, float step) {
  return static_cast<std::int32_t>(v / step);
}
inline float from_steps(std::int32_t n, float step) {
  return static_cast<float>(n) * step;
}

/// To the nearest, half a step away from zero; what is not finite or beyond what can be told in steps stays as it is.
inline float to_nearest(float v, float step) {
  const float n = v / step;
  if (!(std::abs(n) < static_cast<float>(kMostSteps))) return v;
  return from_steps(static_cast<std::int32_t>(static_cast<double>(n) + (n < 0 ? -0.5 : 0.5)), step);
}
/// Likewise, towards zero. So are velocities told: to the nearest, what slows down by less than half a step a tick
/// would never come to rest if it were told at every tick.
inline float towards_zero(float v, float step) {
  const float n = v / step;
  if (!(std::abs(n) < static_cast<float>(kMostSteps))) return v;
  return from_steps(static_cast<std::int32_t>(n), step);
}

inline Vec2 rounded_place(Vec2 v) {
  return {to_nearest(v.x, kPlaceStep), to_nearest(v.y, kPlaceStep)};
}
inline Vec2 rounded_motion(Vec2 v) {
  return {towards_zero(v.x, kMotionStep), towards_zero(v.y, kMotionStep)};
}
inline BodyState rounded(const BodyState& s) {
  return {rounded_place(s.position), to_nearest(s.angle, kPlaceStep), rounded_motion(s.velocity),
          towards_zero(s.spin, kMotionStep), s.awake};
}

}  // namespace padr
