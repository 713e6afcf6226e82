#include "common/node/sides.h"

#include <algorithm>
#include <iterator>

namespace padr::node {

void Sides::on_change(const MemberChange& change) {
  if (change.kind == MemberChange::Kind::kAdmitted)
    std::erase_if(gone_, [&](const Gone& g) { return same_place(g.at, change.at); });
  if (change.kind == MemberChange::Kind::kRemoved) remember(change.at, change.tick);
}

void Sides::remember(const Endpoint& at, Tick now) {
  const bool known = std::any_of(gone_.begin(), gone_.end(), [&](const Gone& g) { return g.at == at; });
  if (!at.is_set() || known) return;
  if (gone_.size() == kMost) gone_.erase(gone_.begin());
  gone_.push_back({at, now});
}

std::vector<Endpoint> Sides::gone() const {
  std::vector<Endpoint> places;
  for (const Gone& g : gone_) places.push_back(g.at);
  return places;
}

bool Sides::member_at(const Endpoint& where, const Node& node) const {
  for (PeerId p = 0; p < desk_.roster.size(); ++p)
    if (p != desk_.self && desk_.roster[p] == where && node.other(p).reachable()) return true;
  return false;
}

Sides::Side Sides::ours(const Node& node) const {
  Side s;
  for (PeerId p = 0; p < node.config().slots; ++p) {
    const Neighbour& n = node.other(p);
    const auto disowned = disowned_by_.find(p);
    const bool out = disowned != disowned_by_.end() && disowned->second == n.incarnation;
    if (p == node.self()) {
      s.push_back({p, node.config().incarnation, 0});
    } else if (n.there() && n.proven && !out && !Removals::suspected(node, p)) {
      s.push_back({p, n.incarnation, 0});
    }
  }
  return s;
}

void Sides::on_probe(const Endpoint& from, PeerId sender, const wire::Probe& probe, std::size_t bytes, const Node& node,
                     Micros local) {
  if (!node.member() || sender >= desk_.slots) return;
  if (sender == desk_.self && probe.incarnation == node.config().incarnation) {  // our own knock, at our own door
    std::erase_if(gone_, [&](const Gone& g) { return g.at == from; });
    return;
  }
  const Neighbour& n = node.other(sender);
  const bool known = n.there() && n.incarnation == probe.incarnation && desk_.roster[sender] == from;
  if (node.now() - node.in_since() < kGrace) return;  // we have hardly heard those among whom we are
  if (known) {
    // Or said before its sender heard that we are in.
    if (probe.knows_you || probe.newest < node.config().incarnation) return;
    disowned_by_[sender] = n.incarnation;
  } else if (member_at(from, node)) {
    return;  // said in another life
  }
  const Side us = ours(node);
  // Two sides have nobody in common. As long as somebody seems to be on both, somebody's word is old.
  const bool disjoint = std::none_of(us.begin(), us.end(), [&](const wire::Seat& s) {
    return std::find(probe.members.begin(), probe.members.end(), s) != probe.members.end();
  });
  const bool larger = probe.members.size() > us.size();
  const bool senior =
      probe.members.size() == us.size() &&
      std::lexicographical_compare(probe.members.begin(), probe.members.end(), us.begin(), us.end(),
                                   [](const wire::Seat& a, const wire::Seat& b) {
                                     return std::pair(a.slot, a.incarnation) < std::pair(b.slot, b.incarnation);
                                   });
  if (disjoint && (larger || senior)) {
    if (!winner_)
      desk_.note("met " + std::to_string(probe.members.size()) + " peers that go on without us, who are " +
                     std::to_string(us.size()) + ": joining them by " + to_string(from),
                 true);
    winner_ = from;
    won_at_ = node.now();
    return;
  }
  if (winner_ == from) winner_.reset();
  if (!desk_.may_answer(local)) return;
  send_probe(from, known, node);
  if (!known) hold_back_beyond(from, bytes);
}

// Whoever that is has proven nothing, and gets no more than it has sent: where we are many, an answer to some of its
// probes.
void Sides::hold_back_beyond(const Endpoint& to, std::size_t bytes) {
  if (desk_.config.sealed) return;
  auto it = std::find_if(credits_.begin(), credits_.end(), [&](const Credit& c) { return c.at == to; });
  if (it == credits_.end()) {
    if (credits_.size() == kMost) credits_.erase(credits_.begin());
    credits_.push_back({to, 0});
    it = std::prev(credits_.end());
  }
  it->bytes = std::min(it->bytes + bytes, wire::kMaxDatagram);
  const std::size_t answer = desk_.outgoing.back().bytes.size();
  if (answer > it->bytes)
    desk_.outgoing.pop_back();
  else
    it->bytes -= answer;
}

std::optional<Endpoint> Sides::winner(const Node& node) const {
  return winner_ && node.now() - won_at_ < kLately ? winner_ : std::nullopt;
}

void Sides::send_probe(const Endpoint& to, bool knows, const Node& node) {
  desk_.send(to, wire::Probe{node.config().incarnation, ours(node), knows, node.newest_incarnation()});
}

void Sides::on_stranger(const Endpoint& from, std::size_t bytes, const Node& node, Micros local) {
  if (!node.member() || member_at(from, node) || !desk_.may_answer(local)) return;
  send_probe(from, false, node);
  // Whoever that is has proven nothing: no answer is larger than what provoked it.
  if (desk_.outgoing.back().bytes.size() > bytes) desk_.outgoing.pop_back();
}

void Sides::knock(const Endpoint& at, const Node& node) {
  if (node.member() && !member_at(at, node)) send_probe(at, false, node);
}

void Sides::advance(const Node& node) {
  if (!node.member() || node.now() - probed_ < kPace) return;
  probed_ = node.now();
  std::erase_if(gone_, [&](const Gone& g) { return node.now() - g.since > kRemember || member_at(g.at, node); });
  for (const Gone& g : gone_) send_probe(g.at, false, node);
}

}  // namespace padr::node
