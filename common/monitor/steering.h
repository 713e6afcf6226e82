#pragma once

#include <optional>

#include "common/monitor/orders.h"
#include "common/world/view.h"

namespace padr::monitor {

/// Where an avatar is driven: by its own input, or by orders as long as there are any.
class Steering {
 public:
  /// `now`: microseconds of the caller's clock, as below.
  void take(const Drive& drive, Micros now);

  /// The target of the next step, m. `own`: what the own input wants; `world`: the live one. Points that are ordered
  /// are kept within the scene's corners. On release the own input goes on, from wherever the avatar is; as long as
  /// the input itself stands still, so does the avatar.
  Vec2 target(Vec2 own, const world::View& world, EntityId avatar, Micros now);

  /// As of the last target.
  bool driven() const { return drive_.has_value(); }

 private:
  Vec2 ordered(const world::View& world, EntityId avatar);
  Vec2 towards(const world::View& world, EntityId avatar, Vec2 direction);
  Vec2 standing(const world::View& world, EntityId avatar);

  std::optional<Drive> drive_;
  Micros until_ = 0;
  std::optional<Vec2> far_;    ///< m, a target far ahead in the direction that is driven
  std::optional<Vec2> stand_;  ///< m, where the avatar has come to stand
  struct Left {
    Vec2 own;  ///< what the own input wanted when the avatar was left
    Vec2 at;   ///< where it stays meanwhile
  };
  std::optional<Left> left_;
};

}  // namespace padr::monitor
