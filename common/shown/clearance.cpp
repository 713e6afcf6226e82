#include "common/shown/clearance.h"

#include <algorithm>

#include "common/world/bounding_radius.h"

namespace padr::sync {

Clearance::Clearance(const Scene& scene, int slots)
    : outlines_(world::outlines(scene, slots)), reaches_(world::reaches(scene, slots)) {
  for (const BodyDef& d : scene.statics) fixed_.push_back({world::outline_of(d), {d.position, d.angle}});
}

bool Clearance::is_wall_between(Vec2 from, Vec2 to) const {
  return std::any_of(fixed_.begin(), fixed_.end(),
                     [&](const Fixed& f) { return world::crosses(from, to, f.shape, f.at); });
}

Clearance::Thing Clearance::thing(EntityId e, const world::View& live, const std::vector<Vec2>& before,
                                  const std::vector<Vec2>& shown) const {
  const world::Kinematics& k = live.kinematics()[e];
  return {outlines_[e], {shown[e], k.angle}, {before[e], k.angle}, {k.position, k.angle}};
}

/// How `a` has to be moved, m.
Vec2 Clearance::way_out(const Thing& a, const Thing& b) {
  const world::Overlap now = world::overlap(a.shape, a.shown, b.shape, b.shown);
  if (now.depth <= 0) return {};
  const float live = world::overlap(a.shape, a.live, b.shape, b.live).depth;
  const float before = world::overlap(a.shape, a.before, b.shape, b.before).depth;
  return now.away * std::max(0.0F, now.depth - std::max(live, before));
}

const std::vector<EntityId>& Clearance::keep(const world::View& live, const std::vector<EntityId>& led,
                                             const std::vector<Vec2>& before, std::vector<Vec2>& shown) {
  moved_.clear();
  const auto move = [&](EntityId e, Vec2 by) {
    shown[e] = shown[e] + by;
    moved_.push_back(e);
  };
  for (const EntityId a : led) {
    if (!live.present(a)) continue;
    for (EntityId b = 0; b < live.entities(); ++b) {
      if (b == a || !live.present(b) || !world::within_reach(shown[a], reaches_[a], shown[b], reaches_[b])) continue;
      const Vec2 out = way_out(thing(a, live, before, shown), thing(b, live, before, shown));
      if (out == Vec2{} || dot(out, live.position(a) - live.position(b)) < 0) continue;
      const bool both = b > a && std::binary_search(led.begin(), led.end(), b);
      move(a, both ? out * 0.5F : out);
      if (both) move(b, out * -0.5F);
    }
    for (const Fixed& f : fixed_) {
      const Vec2 out = way_out(thing(a, live, before, shown), {f.shape, f.at, f.at, f.at});
      if (out != Vec2{}) move(a, out);
    }
  }
  std::sort(moved_.begin(), moved_.end());
  moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());
  return moved_;
}

}  // namespace padr::sync
