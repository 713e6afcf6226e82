#include "common/world/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/model/portable_math.h"

namespace padr::world {
namespace {

/// A rotation.
struct Axes {
  explicit Axes(float angle) : Axes(sin_cos(static_cast<double>(angle))) {}
  explicit Axes(const SinCos& s) : x{static_cast<float>(s.cos), static_cast<float>(s.sin)}, y{-x.y, x.x} {}
  Vec2 x;
  Vec2 y;
  Vec2 into(Vec2 v) const { return {dot(v, x), dot(v, y)}; }
  Vec2 out_of(Vec2 v) const { return x * v.x + y * v.y; }
};

Overlap of_circles(float radii, Vec2 from_b) {
  const float apart = length(from_b);
  if (apart >= radii) return {};
  return {radii - apart, apart > 0 ? from_b * (1 / apart) : Vec2{1, 0}};
}

/// Which side of a box is nearest to a point inside it.
Overlap out_of_box(Vec2 half, Vec2 p) {
  const float right = half.x - std::abs(p.x);
  const float up = half.y - std::abs(p.y);
  if (right < up) return {right, {p.x < 0 ? -1.0F : 1.0F, 0}};
  return {up, {0, p.y < 0 ? -1.0F : 1.0F}};
}

Overlap of_circle_and_box(float radius, Vec2 from_box, const Outline& box, float angle) {
  const Axes axes(angle);
  const Vec2 p = axes.into(from_box);
  const Vec2 nearest{std::clamp(p.x, -box.half.x, box.half.x), std::clamp(p.y, -box.half.y, box.half.y)};
  Overlap o = p == nearest ? out_of_box(box.half, p) : of_circles(radius, p - nearest);
  if (p == nearest) o.depth += radius;
  o.away = axes.out_of(o.away);
  return o;
}

/// How far a box reaches along a direction.
float extent(const Outline& box, const Axes& axes, Vec2 way) {
  return std::abs(dot(axes.x, way)) * box.half.x + std::abs(dot(axes.y, way)) * box.half.y;
}

Overlap of_boxes(const Outline& a, float angle_a, const Outline& b, float angle_b, Vec2 from_b) {
  const Axes of_a(angle_a);
  const Axes of_b(angle_b);
  Overlap least{std::numeric_limits<float>::max(), {}};
  for (const Vec2 way : std::array{of_a.x, of_a.y, of_b.x, of_b.y}) {
    const float along = dot(from_b, way);
    const float depth = extent(a, of_a, way) + extent(b, of_b, way) - std::abs(along);
    if (depth <= 0) return {};
    if (depth < least.depth) least = {depth, along < 0 ? way * -1 : way};
  }
  return least;
}

}  // namespace

bool crosses(Vec2 from, Vec2 to, const Outline& shape, Pose at) {
  if (shape.shape == ShapeKind::kCircle) return distance_to_segment(at.position, from, to) < shape.radius;
  const Axes axes(at.angle);
  const Vec2 a = axes.into(from - at.position);
  const Vec2 way = axes.into(to - at.position) - a;
  float enters = 0;
  float leaves = 1;
  for (const auto& [at_side, along, half] :
       {std::array{a.x, way.x, shape.half.x}, std::array{a.y, way.y, shape.half.y}}) {
    if (along == 0) {
      if (std::abs(at_side) >= half) return false;
      continue;
    }
    const float one = (-half - at_side) / along;
    const float other = (half - at_side) / along;
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  return enters < leaves;
}

Outline outline_of(const BodyDef& d) {
  return {d.shape, d.radius, d.half};
}

std::vector<Outline> outlines(const Scene& scene, int slots) {
  std::vector<Outline> all;
  for (const BodyDef& d : scene.bodies) all.push_back(outline_of(d));
  all.resize(all.size() + static_cast<std::size_t>(slots), {ShapeKind::kCircle, scene.avatar.radius, {}});
  return all;
}

Overlap overlap(const Outline& a, Pose at_a, const Outline& b, Pose at_b) {
  const Vec2 from_b = at_a.position - at_b.position;
  const bool round_a = a.shape == ShapeKind::kCircle;
  const bool round_b = b.shape == ShapeKind::kCircle;
  if (round_a && round_b) return of_circles(a.radius + b.radius, from_b);
  if (round_a) return of_circle_and_box(a.radius, from_b, b, at_b.angle);
  if (!round_b) return of_boxes(a, at_a.angle, b, at_b.angle, from_b);
  Overlap o = of_circle_and_box(b.radius, from_b * -1, a, at_a.angle);
  o.away = o.away * -1;
  return o;
}

}  // namespace padr::world
