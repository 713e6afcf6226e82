#pragma once

#include <algorithm>
#include <cmath>

#include "common/model/ids.h"
#include "common/model/state.h"
#include "common/model/vec.h"
#include "common/world/snapshot.h"

namespace padr::sync {

/// How far off an entity is in what the others believe.
struct EntityError {
  float metres = 0;        ///< shift, with rotation as metres at the rim
  float soon_metres = 0;   ///< the position's shift two ticks on
  float ahead_metres = 0;  ///< the same as `metres` after the difference in velocity has acted for a while
  bool differs = false;    ///< in any bit

  /// `rim`: m, distance from the centre that turns fastest.
  EntityError(const BodyState& truth, const world::Kinematics& believed, float rim) {
    differs = truth != BodyState{believed.position, believed.angle, believed.velocity, believed.spin, believed.awake};
    if (!differs) return;
    const Vec2 shift = truth.position - believed.position;
    const Vec2 drift = truth.velocity - believed.velocity;
    const float turn = std::abs(truth.angle - believed.angle) * rim;
    metres = std::max(length(shift), turn);
    soon_metres = length(shift + drift * kSoon);
    ahead_metres = std::max(length(shift + drift * kHorizon), turn);
  }

 private:
  /// A word takes a tick at least; the second is for what the first adds to the velocity.
  static constexpr float kSoon = 2 * kTickSeconds;
  /// A wrong velocity is an error to come: it counts with what it will have shifted the body by after this time.
  static constexpr float kHorizon = 0.1F;  // s
};

}  // namespace padr::sync
