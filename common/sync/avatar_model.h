#pragma once

#include <vector>

#include "common/sync/updates.h"
#include "common/world/world.h"

namespace padr::sync {

/// What is believed of one avatar since its last update.
struct AvatarModel {
  bool present = false;
  Model kind = Model::kFirst;
  Vec2 velocity;  ///< m/s at `since`
  Vec2 control;   ///< see AvatarUpdate::control
  Tick since = 0;
  bool at_rest = true;
  friend bool operator==(const AvatarModel&, const AvatarModel&) = default;
};

/// Prepares the avatar of peer p for the step from tick `now`: force or velocity, as its model has it. The physics
/// moves it, so walls, other avatars and bodies that it is known to hold are part of the model.
void drive_model(world::World& world, PeerId p, const AvatarModel& model, Tick now);

}  // namespace padr::sync
