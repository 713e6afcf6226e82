#pragma once

#include <vector>

#include "common/sync/fold.h"

namespace padr::sync {

/// What the user sees and plays in: the own avatar moved by real input and touching everything, bodies under own
/// authority moved by real contacts, and everything else taken from the predicted world.
class LiveWorld {
 public:
  LiveWorld(const Scene& scene, const FoldState& start, PeerId self, bool authority);

  /// Takes over the predicted state of all that is not this peer's own. `own` is by entity id.
  void adopt(const FoldState& predicted, const std::vector<bool>& own);
  /// Advances one tick with the own avatar driven towards `target` (m).
  void step(Vec2 target);

  /// Adds to a body's velocity, m/s; no body gets faster than 60 m/s, half of what Box2D can do.
  void push(EntityId b, Vec2 velocity);

  /// What this peer has just told to be at rest is at rest here too: a neighbour that others own, sleeping and put back
  /// to sleep every tick, would keep Box2D from letting it sleep.
  void settle(const Bundle& told);

  const world::World& world() const { return world_; }
  PeerId self() const { return self_; }
  EntityId avatar() const { return world_.avatar(self_); }

 private:
  world::World world_;
  PeerId self_;
  Tick tick_ = 0;
  std::vector<AvatarModel> avatars_;
  std::vector<std::uint32_t> holds_;
};

}  // namespace padr::sync
