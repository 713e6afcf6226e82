// A Replica's part in links that fail: which peers answer, which updates others relay to it, and which it offers to
// relay.
#include <algorithm>

#include "common/replica/replica.h"

namespace padr::node {

using sync::DropReason;

void Replica::note_answer(Neighbour& from, Tick mark) {
  from.answer_mark = std::max(from.answer_mark, mark);
  from.answered = now();
  from.given_up = -1;
  from.given_up_for_good = false;
}

void Replica::give_up(PeerId p, bool for_good) {
  others_[p].given_up = now();
  others_[p].given_up_for_good |= for_good;
}

Tick Replica::unanswered(PeerId p) const {
  constexpr Tick kGivenUp = 1000 * kTicksPerSecond;
  const Neighbour& n = others_[p];
  return n.given_up >= 0 ? kGivenUp : now() - std::max(n.answered, n.relayed);
}

Tick Replica::unacknowledged(PeerId p) const {
  const std::uint32_t acked = std::max(others_[p].link.acked(), own_first_);
  if (acked >= own_end()) return 0;
  return std::max(0, now() - std::max(own_log_[acked - own_first_].tick, others_[p].excused));
}

DropReason Replica::relay(PeerId p, std::uint32_t incarnation, const std::vector<sync::Bundle>& updates) {
  Neighbour& of = others_[p];
  if (p == config_.self || !of.reachable() || of.frozen || incarnation != of.incarnation) return DropReason::kForeign;
  sync::StatePacket packet;  // that p would have sent with these
  packet.updates = updates;
  packet.mark_tick = updates.back().tick;
  packet.mark_count = updates.back().index + 1;
  if (const DropReason why = sync::admit(packet, scene_, config_.slots, now()); why != DropReason::kNone) return why;
  for (const sync::Bundle& b : updates)
    if (b.index < of.first) return DropReason::kForeign;
  if (const DropReason why = check_claims(packet, p); why != DropReason::kNone) return why;
  if (judge_)
    if (const DropReason objection = judge_(packet); objection != DropReason::kNone) return objection;
  const std::uint32_t had = agreed_.log().have(p);
  if (const DropReason why = file_updates(packet, p); why != DropReason::kNone) return why;
  if (agreed_.log().have(p) == had || !of.there()) return DropReason::kNone;
  of.relayed = std::max(of.relayed, packet.mark_tick);
  if (of.relayed > of.given_up && !of.given_up_for_good) of.given_up = -1;
  return DropReason::kNone;
}

// An update that says nothing, but is one: for whoever does not hear us, but may hear those who do.
void Replica::publish_heartbeat() {
  if (!own_log_.empty() && own_log_.back().tick > now() - kHeartbeat) return;
  const bool missed = std::any_of(others_.begin(), others_.end(), [this](const Neighbour& n) {
    const Tick unanswered = n.link.unanswered(now());
    return &n != &others_[config_.self] && n.there() && unanswered >= kRelayAfter && unanswered < kRelayUntil;
  });
  if (!missed) return;
  sync::Bundle nothing;
  nothing.peer = config_.self;
  nothing.tick = now();
  publish(nothing);
}

Micros Replica::clock_lead() const {
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && others_[p].there()) return others_[p].clock.lead();
  return 0;
}

}  // namespace padr::node
