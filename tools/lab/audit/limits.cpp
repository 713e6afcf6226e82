#include "tools/lab/audit/limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/lab/audit/margins.h"

namespace padr::lab::audit {
namespace {

float to_box(const BodyDef& box, Vec2 p) {
  const Vec2 from = p - box.position;
  const float c = std::cos(box.angle);
  const float s = std::sin(box.angle);
  const Vec2 local{c * from.x + s * from.y, c * from.y - s * from.x};
  const Vec2 outside{std::max(std::abs(local.x) - box.half.x, 0.0F), std::max(std::abs(local.y) - box.half.y, 0.0F)};
  return length(outside);
}

float highest_restitution(const Scene& scene) {
  float highest = scene.avatar.restitution;
  for (const std::vector<BodyDef>* some : {&scene.bodies, &scene.statics})
    for (const BodyDef& d : *some) highest = std::max(highest, d.restitution);
  return highest;
}

/// m/s, of what falls through the whole scene.
float fall_speed_of(const Scene& scene) {
  const Vec2 size = scene.upper - scene.lower;
  return std::sqrt(2 * (std::abs(scene.gravity.x) * size.x + std::abs(scene.gravity.y) * size.y));
}

}  // namespace

Limits::Limits(const Scene& scene, int slots)
    : scene_(&scene),
      reaches_(world::reaches(scene, slots)),
      avatar_speed_(scene.avatar.max_speed * kSpeedShare + kSpeedMargin),
      avatar_acceleration_(scene.avatar.max_force / scene.avatar.mass),
      fall_speed_(fall_speed_of(scene)),
      restitution_(highest_restitution(scene)) {
  if (scene.avatar.gravity) {
    avatar_speed_ += fall_speed_;
    avatar_acceleration_ += length(scene.gravity);
  }
  for (const BodyDef& d : scene.bodies) avatar_share_ = std::max(avatar_share_, d.mass / (d.mass + scene.avatar.mass));
}

// Avatars of others are led by their models and give way to nobody: they count as infinitely heavy.
float Limits::avatar_speed_touching(float avatars, float bodies) const {
  const float e = scene_->avatar.restitution;
  const float by_avatars = avatars > 0 ? e * avatar_speed_ + (1 + e) * avatars : 0;
  const float change = (1 + restitution_) * avatar_share_;
  const float by_bodies = std::max(change - 1, 0.0F) * avatar_speed_ + std::max(change, 1.0F) * bodies;
  return std::max({avatar_speed_, by_avatars, by_bodies}) * kTouchingShare + kTouchingMargin;
}

float Limits::body_speed(float fastest) const {
  return (1 + restitution_) * std::max(avatar_speed_, fastest) * kBodySpeedShare + fall_speed_ + kBodySpeedMargin;
}

float Limits::to_obstacle(Vec2 p) const {
  float nearest = std::numeric_limits<float>::max();
  for (const BodyDef& d : scene_->statics) {
    const float gap = d.shape == ShapeKind::kCircle ? std::max(distance(p, d.position) - d.radius, 0.0F) : to_box(d, p);
    nearest = std::min(nearest, gap);
  }
  return nearest;
}

}  // namespace padr::lab::audit
