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

bool PartitionMerge::member_at(const Endpoint& where, const Replica& replica) const {
  for (PeerId p = 0; p < replica.config().slots; ++p)
    if (p != session_.self && replica.other(p).at == where && replica.other(p).reachable()) return true;
  return false;
}

PartitionMerge::Side PartitionMerge::ours(const Replica& replica) const {
  Side s;
  for (PeerId p = 0; p < replica.config().slots; ++p) {
    const Neighbour& n = replica.other(p);
    const auto disowned = disowned_by_.find(p);
    const bool disowns = disowned != disowned_by_.end() && disowned->second == n.incarnation;
    if (p == replica.self()) {
      s.push_back({p, replica.config().incarnation, 0});
    } else if (n.there() && n.proven && !disowns && !Evictions::suspected(replica, p)) {
      s.push_back({p, n.incarnation, 0});
    }
  }
  return s;
}

// Two sides have nobody in common. As long as somebody seems to be on both, somebody's word is old.
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
                              const Replica& replica, Micros local, Commands& out) {
  if (!replica.member() || sender >= session_.slots) return;
  if (sender == session_.self && probe.incarnation == replica.config().incarnation) {  // our own knock, at our own door
    std::erase_if(gone_, [&](const Gone& g) { return g.at == from; });
    return;
  }
  const Neighbour& n = replica.other(sender);
  const bool known = n.there() && n.incarnation == probe.incarnation && n.at == from;
  if (replica.now() - replica.in_since() < kGrace) return;  // we have hardly heard those among whom we are
  if (known) {
    // Or said before its sender heard that we are in.
    if (probe.knows_you || probe.newest < replica.config().incarnation) return;
    disowned_by_[sender] = n.incarnation;
  } else if (member_at(from, replica)) {
    return;  // said in another life
  }
  const Side us = ours(replica);
  if (outranks(probe.members, us)) {
    if (!winner_)
      out.tell({.kind = SessionEvent::Kind::kOutvoted, .at = from, .count = probe.members.size(), .own = us.size()});
    winner_ = from;
    won_at_ = replica.now();
    return;
  }
  if (winner_ == from) winner_.reset();
  if (!out.may_answer(local)) return;
  if (known) return out.send(from, our_probe(true, replica));
  reply_within_credit(from, bytes, replica, out);
}

// Whoever that is has proven nothing, and gets no more than it has sent: where we are many, an answer to some of its
// probes.
void PartitionMerge::reply_within_credit(const Endpoint& to, std::size_t bytes, const Replica& replica, Commands& out) {
  if (session_.config.sealed) return out.send(to, our_probe(false, replica));
  auto it = std::find_if(credits_.begin(), credits_.end(), [&](const Credit& c) { return c.at == to; });
  if (it == credits_.end()) {
    if (credits_.size() == kMost) credits_.erase(credits_.begin());
    credits_.push_back({to, 0});
    it = std::prev(credits_.end());
  }
  it->bytes = std::min(it->bytes + bytes, wire::kMaxDatagram);
  it->bytes -= out.send_at_most(it->bytes, to, our_probe(false, replica));
}

std::optional<Endpoint> PartitionMerge::winner(const Replica& replica) const {
  return winner_ && replica.now() - won_at_ < kLately ? winner_ : std::nullopt;
}

wire::Probe PartitionMerge::our_probe(bool knows, const Replica& replica) const {
  return {replica.config().incarnation, ours(replica), knows, replica.newest_incarnation()};
}

void PartitionMerge::on_stranger(const Endpoint& from, std::size_t bytes, const Replica& replica, Micros local,
                                 Commands& out) {
  if (!replica.member() || member_at(from, replica) || !out.may_answer(local)) return;
  // Whoever that is has proven nothing: no answer is larger than what provoked it.
  out.send_at_most(bytes, from, our_probe(false, replica));
}

void PartitionMerge::knock(const Endpoint& at, const Replica& replica, Commands& out) {
  if (replica.member() && !member_at(at, replica)) out.send(at, our_probe(false, replica));
}

void PartitionMerge::advance(const Replica& replica, Commands& out) {
  if (!replica.member() || replica.now() - probed_ < kPace) return;
  probed_ = replica.now();
  std::erase_if(gone_, [&](const Gone& g) { return replica.now() - g.since > kRemember || member_at(g.at, replica); });
  for (const Gone& g : gone_) out.send(g.at, our_probe(false, replica));
}

}  // namespace padr::node
