#include "common/node/relay.h"

namespace padr::node {

Relay::Relay(SessionDesk& desk) : desk_(desk), questions_(kMaxPeers), services_(kMaxPeers) {}

void Relay::on_fetch(PeerId from, const wire::Fetch& fetch, const Node& node) {
  if (fetch.slot >= desk_.slots || fetch.slot == desk_.self) return;
  const Neighbour& of = node.other(fetch.slot);
  if (!of.reachable() || of.frozen || of.incarnation != fetch.incarnation) return;
  Service& s = services_[from];
  if (node.now() - s.since >= kPace) s = {node.now(), 0};
  if (s.times >= kServed) return;
  const wire::Fetched f{fetch.slot, fetch.incarnation, node.agreed().log().of(fetch.slot, fetch.from)};
  if (f.updates.empty()) return;
  ++s.times;
  desk_.send(desk_.roster[from], f);
}

void Relay::on_fetched(PeerId from, const wire::Fetched& fetched, RecordedNode& node) {
  if (fetched.slot >= desk_.slots) return;
  Question& q = questions_[fetched.slot];
  const Tick now = node.node().now();
  if (q.to != from || now - q.at > kPatience) return;
  q.to = kNoPeer;
  q.next = now + kHurry;
  node.relay(fetched);
}

// Those that are heard, one after the other.
PeerId Relay::next_to_ask(PeerId about, const Node& node) {
  const auto slots = node.config().slots;
  for (int i = 1; i <= slots; ++i) {
    const auto q = static_cast<PeerId>((asked_last_ + i) % slots);
    if (q == about || q == desk_.self || !node.other(q).there() || node.silence(q) >= Node::kRelayAfter) continue;
    asked_last_ = q;
    return q;
  }
  return kNoPeer;
}

void Relay::advance(const Node& node) {
  if (!node.member()) return;
  for (PeerId p = 0; p < node.config().slots; ++p) {
    const Neighbour& of = node.other(p);
    if (p == desk_.self || !of.there() || of.frozen || of.given_up_for_good) continue;
    // One that is heard, but does not know what has arrived here, repeats nothing.
    const bool lacks = node.silence(p) >= Node::kRelayAfter || node.arrears(p) >= Node::kRelayAfter;
    if (!lacks || node.silence(p) >= Node::kRelayUntil) continue;
    Question& q = questions_[p];
    if (node.now() < q.next) continue;
    const PeerId whom = next_to_ask(p, node);
    if (whom == kNoPeer) return;
    q = {whom, node.now(), node.now() + kPace};
    desk_.send(desk_.roster[whom], wire::Fetch{p, of.incarnation, node.agreed().log().have(p)});
  }
}

}  // namespace padr::node
