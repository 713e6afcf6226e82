#include "common/membership/partition_merge.h"

#include <algorithm>
#include <iterator>

namespace padr::node {

void PartitionMerge::on_change(const MemberChange& change) {
  if (change.kind == MemberChange::Kind::kAdmitted)
    std::erase_if(gone_, [&](const Gone& g) { return same_place(g.at, change.at); });
  if (change.kind == MemberChange::Kind::kRemoved) remember(change.at, change.tick);
}

void PartitionMerge::remember(const Endpoint& at, Tick now) {
  const bool known = std::any_of(gone_.begin(), gone_.end(), [&](const Gone& g) { return g.at == at; });
  if (!at.is_set() || known) return;
  if (gone_.size() == kMost) gone_.erase(gone_.begin());
  gone_.push_back({at, now});
}

std::vector<Endpoint> PartitionMerge::gone() const {
  std::vector<Endpoint> places;
  for (const Gone& g : gone_) places.push_back(g.at);
  return places;
}

bool PartitionMerge::member_at(const Endpoint& where, const View& view) const {
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (p != session_.self && view.roster.seats[p].at == where && view.roster.seats[p].reachable()) return true;
  return false;
}

PartitionMerge::Side PartitionMerge::ours(const View& view) const {
  Side s;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    const Seat& n = view.roster.seats[p];
    const auto disowned = disowned_by_.find(p);
    const bool disowns = disowned != disowned_by_.end() && disowned->second == n.incarnation;
    if (p == view.roster.self) {
      s.push_back({p, view.roster.incarnation, 0});
    } else if (n.there() && n.proven && !disowns && !Evictions::suspected(view, p)) {
      s.push_back({p, n.incarnation, 0});
    }
  }
  return s;
}

// The two parts of a partition have no peer in common. If a peer seems to be in both, one of the lists is out of date.
bool PartitionMerge::outranks(const Side& a, const Side& b) {
  const bool disjoint = std::none_of(b.begin(), b.end(),
                                     [&](const wire::Seat& s) { return std::find(a.begin(), a.end(), s) != a.end(); });
  if (!disjoint || a.size() != b.size()) return disjoint && a.size() > b.size();
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                      [](const wire::Seat& x, const wire::Seat& y) {
                                        return std::pair(x.slot, x.incarnation) < std::pair(y.slot, y.incarnation);
                                      });
}

void PartitionMerge::on_probe(const Endpoint& from, PeerId sender, const wire::Probe& probe, std::size_t bytes,
                              const View& view, Micros local, Commands& out) {
  if (!view.roster.member || sender >= session_.slots) return;
  if (sender == session_.self && probe.incarnation == view.roster.incarnation) {  // our own Probe, at our own address
    std::erase_if(gone_, [&](const Gone& g) { return g.at == from; });
    return;
  }
  const Seat& n = view.roster.seats[sender];
  const bool known = n.there() && n.incarnation == probe.incarnation && n.at == from;
  if (view.roster.now - view.roster.in_since < kGrace) return;  // too early to know who is in our part
  if (known) {
    // A Probe with a lower newest incarnation was sent before its sender knew of our admission.
    if (probe.knows_you || probe.newest < view.roster.incarnation) return;
    disowned_by_[sender] = n.incarnation;
  } else if (member_at(from, view)) {
    return;  // sent by another incarnation
  }
  const Side us = ours(view);
  if (outranks(probe.members, us)) {
    if (!winner_)
      out.tell({.kind = SessionEvent::Kind::kOutvoted, .at = from, .count = probe.members.size(), .own = us.size()});
    winner_ = from;
    won_at_ = view.roster.now;
    return;
  }
  if (winner_ == from) winner_.reset();
  if (!out.may_answer(local)) return;
  if (known) return out.send(from, our_probe(true, view));
  reply_within_credit(from, bytes, view, out);
}

// Without a key the address is unproven, and gets at most as many bytes as it sent: in a large session, a reply to only
// some of its Probes.
void PartitionMerge::reply_within_credit(const Endpoint& to, std::size_t bytes, const View& view, Commands& out) {
  if (session_.config.sealed) return out.send(to, our_probe(false, view));
  auto it = std::find_if(credits_.begin(), credits_.end(), [&](const Credit& c) { return c.at == to; });
  if (it == credits_.end()) {
    if (credits_.size() == kMost) credits_.erase(credits_.begin());
    credits_.push_back({to, 0});
    it = std::prev(credits_.end());
  }
  it->bytes = std::min(it->bytes + bytes, wire::kMaxDatagram);
  it->bytes -= out.send_at_most(it->bytes, to, our_probe(false, view));
}

std::optional<Endpoint> PartitionMerge::winner(const View& view) const {
  return winner_ && view.roster.now - won_at_ < kLately ? winner_ : std::nullopt;
}

wire::Probe PartitionMerge::our_probe(bool knows, const View& view) const {
  return {view.roster.incarnation, ours(view), knows, view.roster.newest_incarnation()};
}

void PartitionMerge::on_stranger(const Endpoint& from, std::size_t bytes, const View& view, Micros local,
                                 Commands& out) {
  if (!view.roster.member || member_at(from, view) || !out.may_answer(local)) return;
  // The address is unproven: the reply is no larger than the datagram that provoked it.
  out.send_at_most(bytes, from, our_probe(false, view));
}

void PartitionMerge::knock(const Endpoint& at, const View& view, Commands& out) {
  if (view.roster.member && !member_at(at, view)) out.send(at, our_probe(false, view));
}

void PartitionMerge::advance(const View& view, Commands& out) {
  if (!view.roster.member || view.roster.now - probed_ < kPace) return;
  probed_ = view.roster.now;
  std::erase_if(gone_, [&](const Gone& g) { return view.roster.now - g.since > kRemember || member_at(g.at, view); });
  for (const Gone& g : gone_) out.send(g.at, our_probe(false, view));
}

}  // namespace padr::node
