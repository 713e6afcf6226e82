#include "common/world/avatar_control.h"

namespace padr::world {
namespace {

// Below these an avatar counts as arrived; half of Box2D's own sleep speed and a fifth of its linear slop.
constexpr float kArrivedSpeed = 0.005F;     // m/s
constexpr float kArrivedDistance = 0.001F;  // m

}  // namespace

Vec2 control_force(const AvatarDef& def, Vec2 position, Vec2 velocity, Vec2 target) {
  const Vec2 wanted = clamp_length((target - position) * (def.stiffness / def.damping), def.max_speed);
  return clamp_length((wanted - velocity) * (def.mass * def.damping), def.max_force);
}

bool has_arrived(Vec2 position, Vec2 velocity, Vec2 target) {
  return distance(position, target) < kArrivedDistance && length(velocity) < kArrivedSpeed;
}

void drive_avatar(World& world, PeerId p, Vec2 target) {
  const EntityId e = world.avatar(p);
  const Vec2 position = world.position(e);
  const Vec2 velocity = world.velocity(e);
  if (has_arrived(position, velocity, target)) return;
  world.apply_force(e, control_force(world.scene().avatar, position, velocity, target));
}

}  // namespace padr::world
