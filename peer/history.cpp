#include "peer/history.h"

namespace padr::peer {
namespace {

constexpr Tick kCheckpointEvery = kTicksPerSecond;

}  // namespace

void History::begin(int life) {
  const auto n = static_cast<std::size_t>(life);
  lives_.resize(n + 1);
  pending_.resize(n + 1);
  lives_[n] = {};
  pending_[n].clear();
}

void History::confirm(int life, Tick tick, std::uint64_t hash) {
  const auto n = static_cast<std::size_t>(life);
  Life& l = lives_[n];
  if (l.confirmed_from < 0) l.confirmed_from = tick;
  l.confirmed = {tick, hash};
  if (tick % kCheckpointEvery != 0) return;
  auto& into = l.came < 0 ? pending_[n] : checkpoints_;
  into[tick] = hash;
  if (into.size() > kCheckpointsKept) into.erase(into.begin());
}

void History::play(int life, PeerId peer, std::uint32_t incarnation, Tick tick) {
  Life& l = lives_[static_cast<std::size_t>(life)];
  l.peer = peer;
  l.incarnation = incarnation;
  l.came = tick;
  checkpoints_.erase(checkpoints_.lower_bound(l.confirmed_from), checkpoints_.end());
  checkpoints_.merge(pending_[static_cast<std::size_t>(life)]);
}

void History::change(const node::MemberChange& c) {
  for (const Life& own : lives_)
    if (c.slot == own.peer && c.incarnation == own.incarnation) return;
  seen_[static_cast<std::size_t>(c.kind)].emplace(c.slot, c.incarnation);
}

History::Checkpoint History::confirmed(int life) const {
  return lives_[static_cast<std::size_t>(life)].confirmed;
}

}  // namespace padr::peer
