#pragma once

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr {

/// What an update tells of an entity: its state at a session tick. Every bit matters: play-out depends on it.
struct BodyState {
  Vec2 position;      ///< m
  float angle = 0;    ///< rad, unbounded; always 0 for avatars
  Vec2 velocity;      ///< m/s
  float spin = 0;     ///< rad/s; always 0 for avatars
  bool awake = true;  ///< false: at rest, velocities are zero
  friend bool operator==(const BodyState&, const BodyState&) = default;
};

/// Two entities that touch after a step, first < second. Fixed obstacles have no entity id and are left out.
struct Contact {
  EntityId first = 0;
  EntityId second = 0;
  friend auto operator<=>(const Contact&, const Contact&) = default;
};

}  // namespace padr
