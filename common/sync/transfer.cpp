#include "common/sync/transfer.h"

namespace padr::sync {

Transfer founding(const Scene& scene, int slots, bool authority, Tick now, std::uint32_t incarnation) {
  constexpr std::uint32_t kFirst = 1;  // its update 0 is the one that lets it in
  Transfer t;
  Fold(scene, slots, 0, authority).save(t.state);
  t.state.tick = now;
  t.state.members[0] = {true, incarnation, false};
  t.slots.resize(static_cast<std::size_t>(slots));
  t.have.assign(static_cast<std::size_t>(slots), 0);
  t.have[0] = kFirst;
  Bundle in;
  in.peer = 0;
  in.tick = now;
  Admission& a = in.admission.emplace();
  a.incarnation = incarnation;
  a.slot = 0;
  a.first = kFirst;
  a.have = t.have;
  t.tail.push_back(std::move(in));
  return t;
}

}  // namespace padr::sync
