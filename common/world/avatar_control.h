#pragma once

#include "common/model/scene.h"
#include "common/model/vec.h"
#include "common/world/world.h"

namespace padr::world {

/// Force (N) that drives an avatar towards `target` (m): the velocity-limited PD law of AvatarDef.
Vec2 control_force(const AvatarDef& def, Vec2 position, Vec2 velocity, Vec2 target);

/// Whether an avatar is where it is wanted and stands: nothing drives it then.
bool has_arrived(Vec2 position, Vec2 velocity, Vec2 target);

/// Applies the control law to one avatar for the coming step. An avatar that has arrived and stands is left alone, so
/// that it can fall asleep and be exactly at rest.
void drive_avatar(World& world, PeerId p, Vec2 target);

}  // namespace padr::world
