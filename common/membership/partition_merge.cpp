#include "common/membership/partition_merge.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace padr::node {

namespace {

template <typename T>
void keep(std::vector<T>& list, const T& entry, std::size_t most) {
  if (list.size() == most) list.erase(list.begin());
  list.push_back(entry);
}

}  // namespace

void PartitionMerge::on_change(const MemberChange& change, const View& view) {
  const auto first_admission = [&] {
    Tick first = change.since;
    for (const Gone& g : returned_)
      if (g.at.key == change.at.key) first = std::min(first, g.since);
    return first;
  };
  if (change.kind == MemberChange::Kind::kRemoved) {
    remember({change.at, first_admission(), change.tick}, view.roster.now);
    for (const Seat& s : view.roster.seats)
      if (s.there()) note_member_at(s.at);
  } else if (change.kind == MemberChange::Kind::kLeft) {
    if (change.at.has_key()) keep_gone({{change.at, first_admission(), change.tick}, view.roster.now, true});
  } else if (change.kind == MemberChange::Kind::kAdmitted) {
    if (change.slot == view.roster.self) own_key_ = change.at.key;
    Gone before{change.at, first_admission(), change.tick};
    for (const Remembered& r : gone_)
      if (r.gone.at.key == change.at.key) before.since = std::min(before.since, r.gone.since);
    for (PeerId p = 0; p < view.roster.slots(); ++p)
      if (p != change.slot && view.roster.seats[p].at.key == change.at.key)
        before.since = std::min(before.since, view.roster.seats[p].since);
    std::erase_if(returned_, [&](const Gone& g) { return g.at.key == change.at.key; });
    if (before.since < change.tick && change.at.has_key()) keep(returned_, before, kMost);
    const auto is_it = [&](const Remembered& r) { return !r.gone.at.has_key() || r.gone.at.key == change.at.key; };
    std::erase_if(gone_, [&](const Remembered& r) { return same_place(r.gone.at, change.at) && is_it(r); });
    note_member_at(change.at);
  }
}

// With another key the place is one member's word: a lost peer there still counts if it speaks for itself.
void PartitionMerge::note_member_at(const Endpoint& place) {
  for (Remembered& r : gone_) r.has_left |= same_place(r.gone.at, place) && r.gone.at.key != place.key;
}

void PartitionMerge::remember(const Gone& gone, Tick now) {
  for (Remembered& r : gone_) {
    if (r.gone.at != gone.at) continue;
    if (r.has_left || !was_member(r.gone)) r = {was_member(gone) ? gone : r.gone, now, false, false, 0, r.before};
    return;
  }
  if (gone.at.is_set()) keep_gone({gone, now});
}

// Those that have said goodbye make room first: nobody looks for them. Many that come and go would displace all others.
void PartitionMerge::keep_gone(const Remembered& r) {
  const auto left = std::find_if(gone_.begin(), gone_.end(), [](const Remembered& g) { return g.has_left; });
  if (gone_.size() == kMost && left != gone_.end()) gone_.erase(left);
  if (gone_.size() < kMost || !r.has_left) keep(gone_, r, kMost);
}

// Where they are, not evidence: this peer was in no session with them and with the present members. Once it has nobody
// else, it goes by what it knew of them.
void PartitionMerge::inherit(const PartitionMerge& before, const View& then, Tick now) {
  had_company_ = now;
  for (PeerId p = 0; p < then.roster.slots(); ++p) {
    const Endpoint& at = then.roster.seats[p].at;
    remember({at, now, now}, now);
    for (Remembered& r : gone_)
      if (r.gone.at == at) r.before = before.since(p, then);
  }
}

std::vector<sync::Transfer::Gone> PartitionMerge::gone() const {
  std::vector<Gone> all;
  for (const Remembered& r : gone_)
    if (!r.has_left) all.push_back(r.gone);
  return all;
}

Tick PartitionMerge::since(PeerId p, const View& view) const {
  const Seat& s = view.roster.seats[p];
  const bool own = p == view.roster.self;
  Tick first = own ? view.roster.in_since : s.since;
  for (const Gone& g : returned_)
    if (g.at.key == (own ? own_key_ : s.at.key)) first = std::min(first, g.since);
  return first;
}

bool PartitionMerge::member_at(const Endpoint& where, const View& view) const {
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (p != session_.self && view.roster.seats[p].at == where && view.roster.seats[p].reachable() &&
        !view.roster.departed(p))
      return true;
  return false;
}

bool PartitionMerge::disowns_us(PeerId p, const View& view) const {
  const auto disowned = disowned_by_.find(p);
  return disowned != disowned_by_.end() && disowned->second == view.roster.seats[p].incarnation;
}

bool PartitionMerge::is_ours(PeerId p, const View& view) const {
  const Seat& n = view.roster.seats[p];
  return p != view.roster.self && n.there() && n.proven && !disowns_us(p, view) && !Evictions::suspected(view, p);
}

bool PartitionMerge::has_company(const View& view) const {
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (is_ours(p, view)) return true;
  return false;
}

PartitionMerge::Side PartitionMerge::ours(const View& view) const {
  Side s;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (p == view.roster.self)
      s.push_back({p, view.roster.incarnation, 0});
    else if (is_ours(p, view))
      s.push_back({p, view.roster.seats[p].incarnation, 0});
  }
  return s;
}

bool PartitionMerge::knows(const Endpoint& at, const View& view) const {
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (p != session_.self && view.roster.seats[p].reachable() && same_place(view.roster.seats[p].at, at)) return true;
  return std::any_of(gone_.begin(), gone_.end(),
                     [&](const Remembered& r) { return !r.has_left && same_place(r.gone.at, at); });
}

PartitionMerge::Witness& PartitionMerge::note_witness(const Endpoint& from, PeerId sender, const wire::Probe& probe,
                                                      Tick now) {
  Witness noted{from, sender, probe.incarnation, now};
  if (session_.config.sealed) noted.members = probe.members;
  std::erase_if(witnesses_, [&](const Witness& w) {
    const bool same = session_.config.sealed ? w.from.key == from.key : w.from == from;
    if (same) noted.answered = w.answered;
    return same || now - w.heard >= kLately;
  });
  keep(witnesses_, noted, kMost);
  return witnesses_.back();
}

void PartitionMerge::on_probe(const Endpoint& from, PeerId sender, const wire::Probe& probe, std::size_t bytes,
                              const View& view, Micros local, Commands& out) {
  if (!view.roster.member || sender >= session_.slots) return;
  if (is_own(from, sender, probe.incarnation, view)) {  // at our own address
    std::erase_if(gone_, [&](const Remembered& r) { return r.gone.at == from; });
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
  Witness& witness = note_witness(from, sender, probe, view.roster.now);
  if (!session_.config.sealed) {
    std::size_t& credit = credit_of(from).bytes;
    credit = std::min(credit + bytes, wire::kMaxDatagram);
  }
  const Side us = ours(view);
  // Whoever has left to join anew and knows nobody any more has nothing to lose.
  const bool is_lost = view.roster.leaving && us.size() == 1;
  const bool stays = view.roster.now < stays_until_ || is_disowned(witness, view.roster.now);
  if (is_lost || (!stays && (has_slept_through(probe, view) || is_outranked(probe, us, view) ||
                             is_larger_for_long(probe, us, view)))) {
    // Whoever tells of it has to be of it: anybody can repeat its list.
    if (!is_lost && !is_witness(from, probe, view)) return;
    if (!winner_)
      out.tell({.kind = SessionEvent::Kind::kOutvoted, .at = from, .count = probe.members.size(), .own = us.size()});
    winner_ = from;
    winner_yields_ = probe.yields;
    won_at_ = view.roster.now;
    return;
  }
  if (winner_ == from) winner_.reset();
  // Once, two parts that did not merge answered each other's replies as fast as these came.
  if (view.roster.leaving || is_awake_for_less(kLately, view) || view.roster.now - witness.answered < kAnswerPace ||
      !out.may_answer(local))
    return;
  witness.answered = view.roster.now;
  if (known) return out.send(from, our_probe(true, view));
  reply_within_credit(from, view, out);
}

// If only one part counted it, each of two that are of the same size could take itself for the one that stays.
void PartitionMerge::on_probe_of_barred(const Endpoint& from, PeerId sender, const wire::Probe& probe,
                                        const View& view) {
  if (view.roster.member && sender < session_.slots && !member_at(from, view))
    note_witness(from, sender, probe, view.roster.now);
}

bool PartitionMerge::is_unproven(const Endpoint& at, const View& view) const {
  if (session_.config.sealed) return false;
  const auto& seats = view.roster.seats;
  return std::none_of(seats.begin(), seats.end(), [&](const Seat& s) { return s.at == at; }) &&
         std::none_of(gone_.begin(), gone_.end(), [&](const Remembered& r) { return r.gone.at == at; });
}

PartitionMerge::Credit& PartitionMerge::credit_of(const Endpoint& at) {
  const auto it = std::find_if(credits_.begin(), credits_.end(), [&](const Credit& c) { return c.at == at; });
  if (it != credits_.end()) return *it;
  keep(credits_, {at, 0}, kMost);
  return credits_.back();
}

// Without a key the address gets at most as many bytes as it sent: in a large session, a reply to only some of its
// Probes.
void PartitionMerge::reply_within_credit(const Endpoint& to, const View& view, Commands& out) {
  if (session_.config.sealed) return out.send(to, our_probe(false, view));
  std::size_t& credit = credit_of(to).bytes;
  credit -= out.send_at_most(credit, to, our_probe(false, view));
}

// A Join fills a datagram.
std::optional<int> PartitionMerge::joins_for(const Endpoint& at, const View& view) {
  if (!is_unproven(at, view)) return std::nullopt;
  std::size_t& credit = credit_of(at).bytes;
  const std::size_t joins = credit / wire::kMaxDatagram;
  credit -= joins * wire::kMaxDatagram;
  return static_cast<int>(joins);
}

// The winner may be a liar that lets nobody in, and as long as this peer asks there, it lets nobody in either. A winner
// that yields may be kept waiting so itself: whoever waits for it has to be more patient, or neither lets the other in.
void PartitionMerge::give_winner_up(const View& view) {
  const Tick now = view.roster.now;
  if (!is_outvoted(view)) yields_since_ = now;
  if (!session_.config.sealed || now - yields_since_ < (winner_yields_ ? 2 * kInVain : kInVain)) return;
  winner_.reset();
  stays_until_ = now + (has_company(view) ? kInVain : kStaysAlone);
}

bool PartitionMerge::is_outvoted(const View& view) const {
  return winner_ && view.roster.now - won_at_ < kLately;
}

std::optional<Endpoint> PartitionMerge::winner(const View& view) const {
  return is_outvoted(view) ? winner_ : std::nullopt;
}

wire::Probe PartitionMerge::our_probe(bool knows, const View& view) const {
  return {view.roster.incarnation, ours(view), knows, view.roster.newest_incarnation(), is_outvoted(view)};
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

bool PartitionMerge::has_been_here(const PublicKey& key, const View& view) const {
  return std::any_of(view.roster.seats.begin(), view.roster.seats.end(),
                     [&](const Seat& s) { return s.reachable() && s.at.key == key; }) ||
         std::any_of(gone_.begin(), gone_.end(),
                     [&](const Remembered& r) { return r.gone.at.key == key && was_member(r.gone); });
}

// Anybody may invent peers. So only those are believed who have been members, and only by who has nobody else.
void PartitionMerge::on_told(const Endpoint& from, const Endpoint& of, const View& view) {
  if (!session_.config.sealed || !view.roster.member || !of.has_key() || of.key == own_key_ || knows(of, view)) return;
  if (!has_been_here(from.key, view)) return;
  std::erase_if(told_, [&](const Told& t) { return t.at.key == of.key; });
  keep(told_, {of, view.roster.now}, kMostTold);
}

// The first time of as many as the other one remembers: there may be no second time. Then of one, the next by slot.
void PartitionMerge::tell_of_ours(Remembered& to, const View& view, Commands& out) {
  std::size_t left = std::exchange(to.told, true) ? 1 : kMostTold;
  for (PeerId tried = 0; tried < view.roster.slots() && left > 0; ++tried) {
    to.next = static_cast<PeerId>((to.next + 1) % view.roster.slots());
    const Seat& s = view.roster.seats[to.next];
    if (to.next == view.roster.self || !s.there() || !s.at.has_key()) continue;
    out.send(to.gone.at, wire::Newcomer{s.at});
    --left;
  }
}

void PartitionMerge::advance(const View& view, Commands& out) {
  // Nobody can join by whoever leaves.
  if (!view.roster.member || view.roster.leaving || view.roster.now - probed_ < kPace) return;
  if (is_awake_for_less(kLately, view)) return;
  probed_ = view.roster.now;
  if (has_company(view)) had_company_ = view.roster.now;
  give_winner_up(view);
  std::erase_if(gone_, [&](const Remembered& r) {
    const bool is_back = std::any_of(view.roster.seats.begin(), view.roster.seats.end(),
                                     [&](const Seat& s) { return s.there() && s.at == r.gone.at; });
    return (view.roster.now - r.kept > kRemember && !session_.config.sealed) || (!r.has_left && is_back);
  });
  const bool tells = view.roster.now - told_at_ >= kTell;
  if (tells) told_at_ = view.roster.now;
  const bool is_turn_of_old = view.roster.now / kPace % (kRarely / kPace) == 0;
  for (Remembered& r : gone_) {
    const bool is_old = view.roster.now - r.kept > kRemember;
    if (r.has_left || member_at(r.gone.at, view) || (is_old && !is_turn_of_old)) continue;
    out.send(r.gone.at, our_probe(false, view));
    if (session_.config.sealed && (tells || !r.told)) tell_of_ours(r, view, out);
  }
  if (!is_lonely(kAlone, view)) return;
  for (const Told& t : told_)
    if (view.roster.now - t.since <= kRemember) out.send(t.at, our_probe(false, view));
}

}  // namespace padr::node
