#pragma once

#include <algorithm>
#include <cmath>

namespace padr {

/// Two floats in metres, metres per second or newtons; the name of the field says which.
struct Vec2 {
  float x = 0;
  float y = 0;
  friend bool operator==(const Vec2&, const Vec2&) = default;
};

inline Vec2 operator+(Vec2 a, Vec2 b) {
  return {a.x + b.x, a.y + b.y};
}
inline Vec2 operator-(Vec2 a, Vec2 b) {
  return {a.x - b.x, a.y - b.y};
}
inline Vec2 operator*(Vec2 a, float s) {
  return {a.x * s, a.y * s};
}
inline float dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.y * b.y;
}
/// sqrt is correctly rounded everywhere, hypot is not: keep it that way.
inline float length(Vec2 a) {
  return std::sqrt(dot(a, a));
}
inline float distance(Vec2 a, Vec2 b) {
  return length(a - b);
}
inline bool is_finite(Vec2 a) {
  return std::isfinite(a.x) && std::isfinite(a.y);
}

/// `v` shortened to at most `limit`.
inline Vec2 clamp_length(Vec2 v, float limit) {
  const float l = length(v);
  return l > limit ? v * (limit / l) : v;
}

/// The point of the segment a-b that is nearest to p.
inline Vec2 nearest_on_segment(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 ab = b - a;
  const float square = dot(ab, ab);
  const float along = square > 0 ? std::clamp(dot(p - a, ab) / square, 0.0F, 1.0F) : 0.0F;
  return a + ab * along;
}

/// Distance from p to the nearest point of the segment a-b.
inline float distance_to_segment(Vec2 p, Vec2 a, Vec2 b) {
  return distance(p, nearest_on_segment(p, a, b));
}

}  // namespace padr
