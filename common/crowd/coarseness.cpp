#include <algorithm>

#include "common/crowd/crowd_peer.h"

namespace padr::crowd {

float coarseness_of(const Plane& plane, Region r, const node::Replica& n) {
  constexpr float kNear = 4;  // m
  constexpr float kRise = 2;  // m for once the usual threshold more
  constexpr float kMost = 8;
  const sync::FoldState& s = n.agreed().predicted_state();
  const Vec2 self = n.live().world().position(n.live().avatar());
  float nearest = kNear + kRise * kMost;
  for (EntityId e = 0; e < s.world.entities.size(); ++e) {
    const Vec2 at = s.world.entities[e].position;
    if (e == n.live().avatar()) continue;
    const bool avatar = n.live().world().is_avatar(e);
    const bool counts = avatar ? s.avatars[e - s.authority.size()].present && outside(plane, r, at) <= plane.threshold
                               : s.world.entities[e].awake;
    if (counts) nearest = std::min(nearest, distance(self, at));
  }
  return std::clamp(1 + (nearest - kNear) / kRise, 1.0F, kMost);
}

}  // namespace padr::crowd
