#include "common/membership/relay.h"

namespace padr::node {

Relay::Relay(const SessionView& session) : session_(session), questions_(kMaxPeers), services_(kMaxPeers) {}

void Relay::on_fetch(PeerId from, const wire::Fetch& fetch, const Replica& replica, Commands& out) {
  if (fetch.slot >= session_.slots || fetch.slot == session_.self) return;
  const Neighbour& of = replica.other(fetch.slot);
  if (!of.reachable() || of.frozen || of.incarnation != fetch.incarnation) return;
  Service& s = services_[from];
  if (replica.now() - s.since >= kPace) s = {replica.now(), 0};
  if (s.times >= kServed) return;
  const wire::Fetched f{fetch.slot, fetch.incarnation, replica.agreed().log().of(fetch.slot, fetch.from)};
  if (f.updates.empty()) return;
  ++s.times;
  out.send(replica.other(from).at, f);
}

void Relay::on_fetched(PeerId from, const wire::Fetched& fetched, const Replica& replica, Commands& out) {
  if (fetched.slot >= session_.slots) return;
  Question& q = questions_[fetched.slot];
  const Tick now = replica.now();
  if (q.to != from || now - q.at > kPatience) return;
  q.to = kNoPeer;
  q.next = now + kHurry;
  out.relay(fetched);
}

// Those that are heard, one after the other.
PeerId Relay::next_to_ask(PeerId about, const Replica& replica) {
  const auto slots = replica.config().slots;
  for (int i = 1; i <= slots; ++i) {
    const auto q = static_cast<PeerId>((asked_last_ + i) % slots);
    if (q == about || q == session_.self || !replica.other(q).there() || replica.silence(q) >= Replica::kRelayAfter)
      continue;
    asked_last_ = q;
    return q;
  }
  return kNoPeer;
}

void Relay::advance(const Replica& replica, Commands& out) {
  if (!replica.member()) return;
  for (PeerId p = 0; p < replica.config().slots; ++p) {
    const Neighbour& of = replica.other(p);
    if (p == session_.self || !of.there() || of.frozen || of.given_up_for_good) continue;
    // One that is heard, but does not know what has arrived here, repeats nothing.
    const bool lacks = replica.silence(p) >= Replica::kRelayAfter || replica.arrears(p) >= Replica::kRelayAfter;
    if (!lacks || replica.silence(p) >= Replica::kRelayUntil) continue;
    Question& q = questions_[p];
    if (replica.now() < q.next) continue;
    const PeerId whom = next_to_ask(p, replica);
    if (whom == kNoPeer) return;
    q = {whom, replica.now(), replica.now() + kPace};
    out.send(replica.other(whom).at, wire::Fetch{p, of.incarnation, replica.agreed().log().have(p)});
  }
}

}  // namespace padr::node
