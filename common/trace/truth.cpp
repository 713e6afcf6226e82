#include "common/trace/truth.h"

namespace padr::trace {

Truth truth_of(const sync::FoldState& confirmed, bool authority) {
  const std::size_t entities = confirmed.world.entities.size();
  const std::size_t bodies = confirmed.authority.size();
  Truth t;
  t.owner.reserve(entities);
  t.present.reserve(entities);
  t.agreed.reserve(entities);
  for (std::size_t e = 0; e < entities; ++e) {
    t.agreed.push_back(confirmed.world.entities[e].position);
    if (e < bodies) {
      t.owner.push_back(authority ? confirmed.authority[e].holder() : PeerId{0});
      t.present.push_back(true);
    } else {
      const auto peer = static_cast<PeerId>(e - bodies);
      t.owner.push_back(peer);
      t.present.push_back(confirmed.avatars[peer].present);
    }
  }
  return t;
}

}  // namespace padr::trace
