#include "common/sync/transfer.h"

namespace padr::sync {

Transfer founding(const Scene& scene, int slots, bool authority, Tick now, std::uint32_t incarnation) {
  Transfer t;
  Fold(scene, slots, 0, authority).save(t.state);
  t.state.tick = now;
  t.state.members[0] = {true, incarnation, false};
  t.slots.resize(static_cast<std::size_t>(slots));
  t.have.assign(static_cast<std::size_t>(slots), 0);
  return t;
}

Transfer founding_anew(const Scene& scene, bool authority, const FoldState& last, std::vector<std::uint32_t> have,
                       std::uint32_t incarnation, bool spectates) {
  const auto slots = static_cast<int>(last.members.size());
  Transfer t;
  Fold fold(scene, slots, 0, authority);
  fold.restore(last);
  Bundle said;
  said.leave = true;
  for (said.peer = 0; said.peer < slots; ++said.peer) fold.apply(said);
  fold.save(t.state);
  // Only a member can let somebody in: its former incarnation does.
  t.state.members[0] = {true, incarnation - 1, false};
  fold.restore(t.state);
  said = {};
  said.peer = 0;
  said.tick = last.tick;
  Admission& in = said.admission.emplace();
  in.slot = 0;
  in.incarnation = incarnation;
  in.spectator = spectates;
  fold.apply(said);
  fold.save(t.state);
  t.have = std::move(have);
  t.slots.resize(t.have.size());
  for (std::size_t p = 0; p < t.have.size(); ++p) t.slots[p].first = t.have[p];
  return t;
}

}  // namespace padr::sync
