#include "peer/history.h"

#include <utility>

namespace padr::peer {
namespace {

constexpr Tick kCheckpointEvery = kTicksPerSecond;

}  // namespace

void History::begin(int incarnation) {
  const auto n = static_cast<std::size_t>(incarnation);
  incarnations_.resize(n + 1);
  pending_.resize(n + 1);
  incarnations_[n] = {};
  pending_[n].clear();
}

void History::confirm(int incarnation, Tick tick, std::uint64_t hash) {
  const auto n = static_cast<std::size_t>(incarnation);
  Incarnation& l = incarnations_[n];
  if (l.confirmed_from < 0) l.confirmed_from = tick;
  l.confirmed = {tick, hash};
  if (tick % kCheckpointEvery != 0) return;
  auto& into = l.came < 0 ? pending_[n] : checkpoints_;
  into[tick] = hash;
  if (into.size() > kCheckpointsKept) into.erase(into.begin());
}

void History::play(int which, PeerId peer, std::uint32_t incarnation, Tick tick) {
  Incarnation& l = incarnations_[static_cast<std::size_t>(which)];
  l.peer = peer;
  l.incarnation = incarnation;
  l.came = tick;
  checkpoints_ = std::move(pending_[static_cast<std::size_t>(which)]);
}

void History::change(const node::MemberChange& c) {
  for (const Incarnation& own : incarnations_)
    if (c.slot == own.peer && c.incarnation == own.incarnation) return;
  seen_[static_cast<std::size_t>(c.kind)].emplace(c.slot, c.incarnation);
}

History::Checkpoint History::confirmed(int incarnation) const {
  return incarnations_[static_cast<std::size_t>(incarnation)].confirmed;
}

}  // namespace padr::peer
