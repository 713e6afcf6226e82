#pragma once

#include <vector>

#include "common/world/overlap.h"
#include "common/world/view.h"

namespace padr::sync {

/// Keeps what is led to its place from being shown inside other things.
///
/// A shown overlap of two things may not grow beyond the deeper of two: what it is in the live world, and what was
/// shown a tick ago. So one that a correction begins with, as the live world had it, is left to shrink. Things that
/// stand the other way round in the live world have to pass each other, and are let through.
class Clearance {
 public:
  Clearance(const Scene& scene, int slots);

  /// `led`: what may be moved, sorted; `before`: shown a tick ago, by entity id, m. Moves shown positions, and returns
  /// which.
  const std::vector<EntityId>& keep(const world::View& live, const std::vector<EntityId>& led,
                                    const std::vector<Vec2>& before, std::vector<Vec2>& shown);

  /// Whether something fixed is in the way from one point to the other, m.
  bool is_wall_between(Vec2 from, Vec2 to) const;

 private:
  struct Fixed {
    world::Outline shape;
    world::Pose at;
  };
  /// A thing at three places.
  struct Thing {
    const world::Outline& shape;
    world::Pose shown;
    world::Pose before;
    world::Pose live;
  };
  Thing thing(EntityId e, const world::View& live, const std::vector<Vec2>& before,
              const std::vector<Vec2>& shown) const;
  static Vec2 way_out(const Thing& a, const Thing& b);

  std::vector<world::Outline> outlines_;  ///< by entity
  std::vector<float> reaches_;            ///< by entity, m
  std::vector<Fixed> fixed_;
  std::vector<EntityId> moved_;
};

}  // namespace padr::sync
