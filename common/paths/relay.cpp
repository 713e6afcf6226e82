#include "common/paths/relay.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace padr::node {
namespace {

/// Number of the first update in the slot that is not of the occupant with that incarnation; none: it never sat there.
std::optional<std::uint32_t> end_of(const Seat& seat, std::uint32_t incarnation) {
  if (seat.incarnation == incarnation) return std::numeric_limits<std::uint32_t>::max();
  const auto is_it = [incarnation](const Former& f) { return f.incarnation == incarnation; };
  const auto former = std::find_if(seat.former.begin(), seat.former.end(), is_it);
  if (former == seat.former.end()) return std::nullopt;
  return std::next(former) == seat.former.end() ? seat.first : std::next(former)->first;
}

}  // namespace

Relay::Relay(const SessionView& session) : session_(session), questions_(kMaxPeers), services_(kMaxPeers) {}

// Also of who has left or was removed, and if another one sits there by now: a member that was out of reach may lack
// its last orders, on which those of the present coordinator rest.
void Relay::on_fetch(PeerId from, const wire::Fetch& fetch, const View& view, Commands& out) {
  if (fetch.slot >= session_.slots || fetch.slot == session_.self) return;
  const Seat& of = view.roster.seats[fetch.slot];
  if (!of.frozen && of.reachable() && of.incarnation == fetch.incarnation) note_unheard(from, fetch.slot, view);
  serve(from, fetch, view, out);
}

void Relay::serve(PeerId asker, const wire::Fetch& wanted, const View& view, Commands& out) {
  Service& s = services_[asker];
  if (view.roster.now - s.since >= kPace) s = {view.roster.now, 0};
  if (s.times >= kServed) return;
  const auto end = end_of(view.roster.seats[wanted.slot], wanted.incarnation);
  if (!end) return;
  wire::Fetched f{wanted.slot, wanted.incarnation, view.log.of(wanted.slot, wanted.from)};
  std::erase_if(f.updates, [end](const sync::Bundle& b) { return b.index >= *end; });
  if (f.updates.empty()) return;
  ++s.times;
  out.send(view.roster.seats[asker].at, f);
}

Tick Relay::note_unheard(PeerId from, PeerId about, const View& view) {
  Unheard& u = unheard_[{from, about}];
  if (view.roster.now - u.last >= kAsksOn) u.since = view.roster.now;
  u.last = view.roster.now;
  return u.last - u.since;
}

PeerSet Relay::unheard_by(PeerId about, Tick now) const {
  PeerSet members = 0;
  for (const auto& [who, u] : unheard_)
    if (who.second == about && now - u.last < kAsksLately) members |= only(who.first);
  return members;
}

void Relay::on_fetched(PeerId from, const wire::Fetched& fetched, const View& view, Commands& out) {
  if (fetched.slot >= session_.slots) return;
  Question& q = questions_[fetched.slot];
  const Tick now = view.roster.now;
  const auto asked = q.asked.find(from);
  if (asked == q.asked.end() || now - asked->second > kPatience) return;
  q.asked.erase(asked);
  q.next = now + kHurry;
  out.relay(fetched, from);
}

// The next member, in turn, that is heard.
PeerId Relay::next_to_ask(PeerId about, const View& view) {
  const auto slots = view.roster.slots();
  for (int i = 1; i <= slots; ++i) {
    const auto q = static_cast<PeerId>((asked_last_ + i) % slots);
    if (q == about || q == session_.self || !view.roster.seats[q].there() || view.roster.silence(q) >= kRelayAfter)
      continue;
    asked_last_ = q;
    return q;
  }
  return kNoPeer;
}

void Relay::advance(const View& view, Commands& out) {
  if (!view.roster.member) return;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    const Seat& of = view.roster.seats[p];
    if (p == session_.self || !of.there() || of.frozen) continue;
    // A peer that does not learn what has arrived here repeats nothing, even if it is heard.
    const bool lacks = view.roster.silence(p) >= kRelayAfter || view.arrears(p) >= kRelayAfter;
    if (!lacks || view.roster.silence(p) >= kRelayUntil) continue;
    Question& q = questions_[p];
    if (view.roster.now < q.next) continue;
    const PeerId whom = next_to_ask(p, view);
    if (whom == kNoPeer) return;
    q.asked[whom] = view.roster.now;
    q.next = view.roster.now + kPace;
    out.send(view.roster.seats[whom].at, wire::Fetch{p, of.incarnation, view.log.have(p)});
  }
}

}  // namespace padr::node
