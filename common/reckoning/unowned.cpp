#include "common/reckoning/unowned.h"

namespace padr::sync {

const std::vector<EntityId>& UnownedBodies::kept(const FoldState& predicted, const world::View& live, PeerId self) {
  kept_.clear();
  const bool first = seen_.empty();
  seen_.resize(predicted.authority.size());
  for (EntityId b = 0; b < seen_.size(); ++b) {
    const Authority& now = predicted.authority[b];
    const bool told = first || (now != seen_[b] && now.owner != self);
    seen_[b] = now;
    if (told || now.holder() != kNoPeer) continue;
    const world::Kinematics& k = predicted.world.entities[b];
    if (live.state(b) != BodyState{k.position, k.angle, k.velocity, k.spin, k.awake}) kept_.push_back(b);
  }
  return kept_;
}

}  // namespace padr::sync
