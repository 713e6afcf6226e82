#include "common/trace/truth.h"

namespace padr::trace {

void take_truth(const sync::FoldState& confirmed, bool authority, Truth& out) {
  out.owner.clear();
  out.present.clear();
  out.agreed.clear();
  for (const world::Kinematics& k : confirmed.world.entities) out.agreed.push_back(k.position);
  for (const sync::Authority& a : confirmed.authority) {
    out.owner.push_back(authority ? a.holder() : kNoPeer);
    out.present.push_back(true);
  }
  PeerId peer = 0;
  for (const sync::AvatarModel& m : confirmed.avatars) {
    out.owner.push_back(peer++);
    out.present.push_back(m.present);
  }
}

Truth truth_of(const sync::FoldState& confirmed, bool authority) {
  Truth t;
  take_truth(confirmed, authority, t);
  return t;
}

}  // namespace padr::trace
