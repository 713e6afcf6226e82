#include "common/sync/avatar_model.h"

#include "common/world/avatar_control.h"

namespace padr::sync {

void drive_model(world::World& world, PeerId p, const AvatarModel& model, Tick now) {
  if (!model.present) return;
  if (model.at_rest && model.kind != Model::kInput) {  // stays, even if somebody bumps into it
    world.set_velocity(world.avatar(p), {0, 0});
    return;
  }
  switch (model.kind) {
    case Model::kStatic:
      world.set_velocity(world.avatar(p), {0, 0});
      return;
    case Model::kFirst:
      world.set_velocity(world.avatar(p), model.velocity);
      return;
    case Model::kSecond: {
      const float age = static_cast<float>(now - model.since + 1) * kTickSeconds;
      const Vec2 v = model.velocity + model.control * age;
      world.set_velocity(world.avatar(p), clamp_length(v, world.scene().avatar.max_speed));
      return;
    }
    case Model::kInput:
      world::drive_avatar(world, p, model.control);
      return;
    case Model::kChosen:
      return;
  }
}

}  // namespace padr::sync
