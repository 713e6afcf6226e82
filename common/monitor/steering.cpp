#include "common/monitor/steering.h"

#include <algorithm>

namespace padr::monitor {
namespace {

// Full speed in one direction is driven towards a point that stays: the others' models, which are told of the target,
// then need no further word. So far off it lies almost straight ahead whatever pushes the avatar aside.
constexpr float kFar = 50;            // m
constexpr float kFull = 0.99F;        // of a direction's length
constexpr float kNone = 0.01F;        // likewise
constexpr float kStandSpeed = 0.05F;  // m/s

}  // namespace

void Steering::take(const Drive& drive, Micros now) {
  if (drive.kind == Drive::Kind::kRelease) {
    until_ = now;
    return;
  }
  if (!drive_ || *drive_ != drive) far_.reset();
  const bool stands = drive.kind == Drive::Kind::kDirection && length(drive.to) < kNone;
  if (!stands) stand_.reset();
  drive_ = drive;
  until_ = now + kDriveLease;
}

Vec2 Steering::target(Vec2 own, const world::View& world, EntityId avatar, Micros now) {
  if (drive_ && now >= until_) {
    drive_.reset();
    far_.reset();
    stand_.reset();
    left_ = Left{own, world.position(avatar)};
  }
  if (drive_) return ordered(world, avatar);
  if (left_ && left_->own != own) left_.reset();
  return left_ ? left_->at : own;
}

Vec2 Steering::ordered(const world::View& world, EntityId avatar) {
  const Scene& scene = world.scene();
  if (drive_->kind == Drive::Kind::kPoint)
    return {std::clamp(drive_->to.x, scene.lower.x, scene.upper.x),
            std::clamp(drive_->to.y, scene.lower.y, scene.upper.y)};
  const Vec2 direction = clamp_length(drive_->to, 1);
  return length(direction) < kNone ? standing(world, avatar) : towards(world, avatar, direction);
}

Vec2 Steering::towards(const world::View& world, EntityId avatar, Vec2 direction) {
  const Vec2 at = world.position(avatar);
  if (length(direction) < kFull) {
    const AvatarDef& a = world.scene().avatar;
    return at + direction * (a.max_speed * a.damping / a.stiffness);
  }
  if (!far_ || distance(at, *far_) < kFar / 2) far_ = at + direction * kFar;
  return *far_;
}

Vec2 Steering::standing(const world::View& world, EntityId avatar) {
  if (!stand_ || length(world.velocity(avatar)) > kStandSpeed) stand_ = world.position(avatar);
  return *stand_;
}

}  // namespace padr::monitor
