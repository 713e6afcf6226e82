#include "common/membership/vouching.h"

#include <algorithm>

#include "common/membership/last_heard.h"
#include "common/membership/misbehaviour_policy.h"
#include "common/paths/relay.h"

namespace padr::node {
namespace {

/// Whether this member and the peer hear each other, and nothing of the peer's is missing here.
bool is_well(const wire::Seat& s, const View& view, Tick due) {
  const Seat& n = view.roster.seats[s.slot];
  return n.there() && n.incarnation == s.incarnation && !n.frozen && n.given_up < 0 &&
         n.answer_mark > due - kHeardLately && view.arrears(s.slot) < kRelayAfter && !view.delays(s.slot);
}

bool has_evidence(PeerId p, const View& view, Tick due) {
  const std::vector<sync::Bundle> recent = view.log.since(std::max(0, due - kHeardLately + 1));
  return std::any_of(recent.begin(), recent.end(), [&](const sync::Bundle& b) {
    return b.peer == p && b.index >= view.roster.seats[p].first && b.index < view.log.have(p);
  });
}

}  // namespace

bool Vouching::vouches_for(const wire::Seat& s, PeerId from, const View& view, Tick due, std::uint32_t number,
                           Relay& relay, Commands& out) {
  const Tick now = view.roster.now;
  Doubted& d = doubted_[{from, s.slot}];
  if (d.incarnation != s.incarnation || now - d.last > 2 * kGrace) d = {s.incarnation, now, now, -kAskAgain};
  d.last = now;
  if (now - d.asked >= kAskAgain) {
    d.asked = now;
    out.send(view.roster.seats[s.slot].at, wire::Poll{{{s.slot, s.incarnation, 0, 0}}, false, number});
  }
  if (!has_evidence(s.slot, view, due)) return now - d.since < kGrace;
  relay.serve(from, {s.slot, s.incarnation, s.have}, view, out);
  return true;
}

bool Vouching::vouches(PeerId from, const wire::Poll& poll, const View& view, Tick due, std::uint32_t number,
                       const MisbehaviourPolicy& misbehaviour, Relay& relay, Commands& out) {
  if (!poll.freeze) return false;
  bool any = false;
  for (const wire::Seat& s : poll.lost) {
    if (s.slot >= session_.slots || s.slot == session_.self || s.slot == from) continue;
    // One of the two. With a key others carry for both, and that one does not hear the other is but its word.
    const bool has_to_go = relay.note_unheard(from, s.slot, view) >= Relay::kUnheardForLong && !session_.config.sealed;
    if (has_to_go || !is_well(s, view, due) || !misbehaviour.hears(s.slot, view)) continue;
    any |= vouches_for(s, from, view, due, number, relay, out);
  }
  return any;
}

void Vouching::prove_alive(const wire::Poll& poll, const View& view, Commands& out) {
  const Roster& r = view.roster;
  const bool asked = std::any_of(poll.lost.begin(), poll.lost.end(), [&](const wire::Seat& s) {
    return s.slot == r.self && s.incarnation == r.incarnation;
  });
  if (!asked || !r.member || r.leaving || r.now - proved_ < kPace) return;
  proved_ = r.now;
  out.publish({});
}

}  // namespace padr::node
