#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/model/ids.h"
#include "common/model/scene.h"
#include "common/world/snapshot.h"

namespace padr::world {

// For playing some entities of a world apart from the others.

/// By entity id, m: nothing of it is farther from its centre, nor touches anything that is. Bodies, then avatar slots.
std::vector<float> reaches(const Scene& scene, int slots);

/// A box around some entities with all that is theirs, m.
class BoundingBox {
 public:
  void clear() { *this = {}; }
  void enclose(Vec2 at, float reach) {
    lower_ = {std::min(lower_.x, at.x - reach), std::min(lower_.y, at.y - reach)};
    upper_ = {std::max(upper_.x, at.x + reach), std::max(upper_.y, at.y + reach)};
  }
  /// Whether something there, with that reach, is clear of it. For most of many entities it is, whichever way they lie:
  /// so there is one branch.
  bool is_clear_of(Vec2 at, float reach) const {
    return ((at.x + reach < lower_.x) | (at.x - reach > upper_.x) | (at.y + reach < lower_.y) |
            (at.y - reach > upper_.y)) != 0;
  }

 private:
  static constexpr float kFarOff = 1e9F;  // m
  Vec2 lower_{kFarOff, kFarOff};
  Vec2 upper_{-kFarOff, -kFarOff};
};

/// Whether two may touch where they are, as far as their reaches tell.
inline bool within_reach(Vec2 a, float reach_a, Vec2 b, float reach_b) {
  const Vec2 gap = b - a;
  const float both = reach_a + reach_b;
  return dot(gap, gap) <= both * both;
}

/// Puts the contacts of `part` in place of those in `into` of entities whose bit in `left_out` is clear.
void replace_contacts(Snapshot& into, const Snapshot& part, const std::vector<bool>& left_out);

}  // namespace padr::world
