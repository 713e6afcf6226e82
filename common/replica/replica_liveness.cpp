// A Replica's part in links that fail: which peers answer, which updates others relay to it, and which it offers to
// relay.
#include <algorithm>
#include <array>
#include <functional>

#include "common/replica/replica.h"

namespace padr::node {

using sync::DropReason;

DropReason Replica::relay(PeerId p, std::uint32_t incarnation, const std::vector<sync::Bundle>& updates, PeerId by) {
  Seat& of = roster_.seats[p];
  if (p == config_.self || !of.reachable() || of.frozen || incarnation != of.incarnation) return DropReason::kForeign;
  sync::StatePacket packet;  // as p would have sent it with these
  packet.updates = updates;
  packet.mark_tick = updates.back().tick;
  packet.mark_count = updates.back().index + 1;
  if (const DropReason why = sync::admit(packet, scene_, config_.slots, now()); why != DropReason::kNone) return why;
  for (const sync::Bundle& b : updates)
    if (b.index < of.first) return DropReason::kForeign;
  if (const DropReason why = check_claims(packet, p); why != DropReason::kNone) return why;
  if (judge_)
    if (const DropReason objection = judge_(packet, by); objection != DropReason::kNone) return objection;
  const std::uint32_t had = agreed_.log().have(p);
  if (const DropReason why = file_updates(packet, p); why != DropReason::kNone) return why;
  if (agreed_.log().have(p) == had || !of.there()) return DropReason::kNone;
  of.relayed = std::max(of.relayed, packet.mark_tick);
  if (of.relayed > of.given_up && !of.given_up_for_good) of.given_up = -1;
  return DropReason::kNone;
}

void Replica::give_up(PeerId p, bool for_good) {
  roster_.give_up(p, for_good);
  if (agreed_.log().closed(p)) return;
  agreed_.forget_promises(p);
  links_[p].promised = agreed_.log().have(p);
}

// An empty update, for a member that does not hear us, but may hear members that do.
void Replica::publish_heartbeat() {
  if (!own_log_.empty() && own_log_.back().tick > now() - kHeartbeat) return;
  bool missed = false;
  for (PeerId p = 0; p < config_.slots; ++p) {
    const Tick unanswered = links_[p].out.unanswered(now());
    missed |= p != config_.self && seat(p).there() && unanswered >= kRelayAfter && unanswered < kRelayUntil;
  }
  if (!missed) return;
  sync::Bundle nothing;
  nothing.peer = config_.self;
  nothing.tick = now();
  publish(nothing);
}

PeerId Replica::most_senior_other() const {
  PeerId first = kNoPeer;
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && seat(p).there() && (first == kNoPeer || roster_.is_senior(p, first))) first = p;
  return first;
}

Micros Replica::clock_lead() const {
  const PeerId first = most_senior_other();
  return first == kNoPeer ? 0 : links_[first].clock.lead();
}

Micros Replica::least_clock_lead() const {
  return as_most_others_show(&LinkClock::least_lead);
}

Micros Replica::least_clock_lag() const {
  return as_most_others_show(&LinkClock::least_lag);
}

bool Replica::shares_time() const {
  std::size_t others = 0;
  std::size_t alike = 0;
  for (PeerId p = 0; p < config_.slots; ++p) {
    if (p == config_.self || !seat(p).there()) continue;
    ++others;
    const LinkClock& clock = links_[p].clock;
    if (clock.compared() && clock.lead() > -kFarBehind && clock.lead() < kFarBehind) ++alike;
  }
  return others >= 2 && 2 * alike > others;
}

Micros Replica::as_most_others_show(Micros (LinkClock::*what)() const) const {
  std::array<Micros, kMaxPeers> shown;
  std::size_t others = 0;
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && seat(p).there()) shown[others++] = (links_[p].clock.*what)();
  if (others < 2) return 0;
  const auto middle = shown.begin() + static_cast<std::ptrdiff_t>(others / 2);
  std::nth_element(shown.begin(), middle, shown.begin() + static_cast<std::ptrdiff_t>(others), std::greater<>());
  return std::max<Micros>(0, *middle);
}

}  // namespace padr::node
