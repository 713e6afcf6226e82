// A Replica's part in membership: its own admission and farewell, and the admissions and removals of others.
#include <algorithm>
#include <utility>

#include "common/model/observed_address.h"
#include "common/replica/replica.h"

namespace padr::node {
namespace {

// Four marks: time to hear that another peer leaves too, and to acknowledge everything, even if some marks get lost.
constexpr Tick kLastAcks = 62;

/// Arrears up to so long before a removal are forgiven, ticks: what it was in the way of is repeated in the other half
/// of the time that members are allowed. Forgiven up to the removal, whoever tells nothing would be cut off only after
/// the others have joined anew because nothing is confirmed.
constexpr Tick kNotForgiven = 4 * kTicksPerSecond;
/// Most arrears that are forgiven, however many removals there are, ticks: for the same reason.
constexpr Tick kMostForgiven = 3 * kTicksPerSecond;

bool changes_membership(const sync::Bundle& b) {
  return b.leave || b.admission || !b.removals.empty() || !b.passed_on.empty();
}

bool is_earlier(const sync::Bundle& a, const sync::Bundle& b) {
  return a.index < b.index;
}

}  // namespace

void Replica::file(const sync::Bundle& bundle) {
  if (!agreed_.insert(bundle)) return;
  news_ = now();
  std::vector<sync::Bundle>& orders = links_[bundle.peer].orders;
  if (changes_membership(bundle))
    orders.insert(std::upper_bound(orders.begin(), orders.end(), bundle, is_earlier), bundle);
  while (!orders.empty() && orders.front().index < agreed_.log().have(bundle.peer)) {
    const sync::Bundle next = std::move(orders.front());
    orders.erase(orders.begin());
    note_changes(next);
  }
}

// A change takes effect as soon as all updates of its peer before it are here, not when it is confirmed: it decides
// whose updates a confirmed tick needs. If one before it is missing, it may never count: an order that nobody takes
// ends its peer's log. Incarnations put right what is heard out of order.
void Replica::note_changes(const sync::Bundle& b) {
  for (const sync::Bundle& lost : b.passed_on) file(lost);
  for (const sync::Removal& r : b.removals) remove(r, b);
  if (b.admission) admit(*b.admission, b);
  if (b.leave) note_farewell(b);
}

void Replica::note_farewell(const sync::Bundle& b) {
  Seat& n = roster_.seats[b.peer];
  const bool of_before = b.index < (b.peer == config_.self && member() ? own_first_ : n.first);
  if (of_before) return;  // a later peer has the slot already
  agreed_.close(b.peer, b.index + 1);
  if (b.peer == config_.self || !n.there()) return;
  n.presence = Presence::kLeft;
  n.frozen = false;
  links_[b.peer].held.clear();
  changes_.push_back({MemberChange::Kind::kLeft, b.peer, n.incarnation, n.at, b.tick, b.peer, n.since});
}

// Whoever has more of p's updates than the others agreed on has been left behind by them, or lied to by p.
void Replica::close(PeerId p, std::uint32_t count) {
  if (agreed_.log().have(p) > count) expelled_ = true;
  agreed_.close(p, count);
  std::erase_if(links_[p].orders, [count](const sync::Bundle& b) { return b.index >= count; });
}

void Replica::admit(const sync::Admission& a, const sync::Bundle& by) {
  Seat& n = roster_.seats[a.slot];
  if (a.slot == config_.self) {
    if (a.incarnation > config_.incarnation) expelled_ = true;
    if (a.incarnation != config_.incarnation || member()) return;
    roster_.admitted_by = by.peer;
    return take_seat(a.first, by.tick, a.at, by.peer);
  }
  if (a.incarnation <= n.incarnation) return;
  const Endpoint at = as_seen_from(a.at, roster_.place_of_sayer(by));
  close(a.slot, a.first);  // in case the removal of the former occupant comes later
  agreed_.open(a.slot, by.tick);
  repeats_of_gone_ += links_[a.slot].out.repeats();
  LinkState link;
  link.out = sync::OutLink(a.have[config_.self]);
  link.dropped = links_[a.slot].dropped;
  link.orders = std::move(links_[a.slot].orders);
  links_[a.slot] = std::move(link);
  roster_.seat(a.slot, a.incarnation, a.first, at, by.tick);
  n.confirmed = agreed_.confirmed().tick;
  changes_.push_back({MemberChange::Kind::kAdmitted, a.slot, a.incarnation, at, by.tick, by.peer, by.tick});
}

void Replica::take_seat(std::uint32_t first, Tick since, const Endpoint& at, PeerId by) {
  Seat& n = roster_.seats[config_.self];
  agreed_.close(config_.self, first);
  agreed_.enter(since);
  own_first_ = first;
  n.former = {{n.first, n.incarnation, n.at}};
  n.first = first;
  n.presence = Presence::kAbsent;  // of the former occupant
  n.at = {};
  roster_.member = true;
  roster_.in_since = since;
  for (LinkState& link : links_) link.out = sync::OutLink(first);
  for (Seat& s : roster_.seats) s.heard = s.answered = s.excused = now();
  changes_.push_back({MemberChange::Kind::kAdmitted, config_.self, config_.incarnation, at, since, by, since});
}

void Replica::remove(const sync::Removal& r, const sync::Bundle& by) {
  if (r.slot == config_.self) {
    if (r.incarnation == config_.incarnation) expelled_ = true;
    if (!member()) agreed_.close(r.slot, r.count);  // of the former occupant
    return;
  }
  Seat& n = roster_.seats[r.slot];
  if (r.incarnation != n.incarnation || !n.reachable()) return;
  close(r.slot, r.count);
  n.frozen = false;
  links_[r.slot].held.clear();
  if (!n.there()) return;  // it has left: the end of its log is its leave update, which counts
  n.presence = Presence::kAbsent;
  forgive_arrears();
  changes_.push_back({MemberChange::Kind::kRemoved, r.slot, r.incarnation, n.at, by.tick, by.peer, n.since});
}

Tick Replica::told_until(PeerId p) const {
  return std::max(std::min(now(), agreed_.log().complete(p)), roster_.seats[p].excused);
}

void Replica::forgive_arrears() {
  for (PeerId p = 0; p < config_.slots; ++p) {
    Seat& s = roster_.seats[p];
    s.forgiven = std::max(s.forgiven, std::min(now() - kNotForgiven, told_until(p) + kMostForgiven));
  }
}

void Replica::forgive(PeerId p, Tick meanwhile) {
  Seat& s = roster_.seats[p];
  s.forgiven = std::min(now(), std::max(told_until(p), s.forgiven) + meanwhile);
  s.acks_forgiven = std::min(now(), std::max(s.unacknowledged, s.acks_forgiven) + meanwhile);
}

// The log of a frozen peer must not grow any more: not by its datagrams, and not by passed-on updates that fill a gap
// before updates already here.
void Replica::freeze(PeerId p, bool frozen) {
  const Seat& s = roster_.seats[p];
  if (s.frozen == frozen) return;
  if (!frozen && s.answered_frozen > s.answer_mark) forgive(p, roster_.silence(p));  // it repeats what was not taken
  roster_.freeze(p, frozen);
  std::vector<sync::Bundle>& held = links_[p].held;
  if (frozen) {
    held = agreed_.hold(p);
    links_[p].orders.clear();
  } else {
    for (const sync::Bundle& b : std::exchange(held, {})) file(b);
  }
}

std::vector<MemberChange> Replica::take_changes() {
  return std::exchange(changes_, {});
}

bool Replica::delivered() const {
  return through_ticks_ >= kLastAcks;
}

// A peer that has left lingers, and needs our last updates as we need its; once it is silent, it has ended.
bool Replica::all_through() const {
  for (PeerId p = 0; p < config_.slots; ++p) {
    if (p == config_.self || !seat(p).reachable() || roster_.departed(p)) continue;
    if (links_[p].out.acked() < own_end()) return false;
    if (agreed_.log().have(p) < links_[p].promised) return false;
  }
  return true;
}

sync::Transfer Replica::transfer() const {
  sync::Transfer t;
  t.state = agreed_.confirmed();
  t.tail = agreed_.log().since(t.state.tick);
  // Without updates beyond a gap: a removal might close a gap that the joiner never hears of otherwise.
  std::erase_if(t.tail, [&](const sync::Bundle& b) { return b.index >= agreed_.log().have(b.peer); });
  t.slots.resize(roster_.slots());
  t.have.resize(roster_.slots());
  for (PeerId p = 0; p < roster_.slots(); ++p) {
    t.slots[p] = {agreed_.log().have(p), seat(p).at, seat(p).since};
    t.have[p] = agreed_.log().have(p);
  }
  for (const sync::Bundle& b : t.tail) t.slots[b.peer].first = std::min(t.slots[b.peer].first, b.index);
  return t;
}

sync::Transfer Replica::founding_anew(std::uint32_t incarnation) const {
  std::vector<std::uint32_t> have;
  for (PeerId p = 0; p < roster_.slots(); ++p) have.push_back(agreed_.log().have(p));
  return sync::founding_anew(scene_, config_.technique.authority, agreed_.predicted_state(), std::move(have),
                             incarnation, config_.spectates);
}

// The sender of the transfer knows all present addresses. Updates in it have an address as a coordinator saw it, which
// may have gone since, and whose slot may be another peer's by now.
void Replica::keep_places(const sync::Transfer& start) {
  for (PeerId p = 0; p < roster_.slots(); ++p)
    if (p != config_.self && start.slots[p].at.is_set()) roster_.seats[p].at = start.slots[p].at;
  for (MemberChange& c : changes_)
    if (c.slot != config_.self) c.at = seat(c.slot).at;
}

Replica::Replica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start, Tick now,
                 ConfirmedSink on_confirmed)
    : Replica(scene, config, start, std::move(on_confirmed), Later{}) {
  note_time();
  for (PeerId p = 0; p < config.slots; ++p) {
    const sync::Transfer::Slot& s = start.slots[p];
    Seat& n = roster_.seats[p];
    const sync::Member& member = start.state.members[p];
    // A peer that is present in the state may have left or been removed since: then the tail says so.
    n.incarnation = member.incarnation;
    n.at = s.at;
    n.since = s.since;
    n.confirmed = n.heard = n.answered = start.state.tick;
    if (member.present) n.presence = Presence::kThere;
  }
  roster_.admitted_by = start.by;
  const sync::Member& own = start.state.members[config.self];
  if (own.present && own.incarnation == config.incarnation)  // it founds
    take_seat(start.slots[config.self].first, start.state.tick, {}, config.self);
  for (const sync::Bundle& b : start.tail) file(b);
  keep_places(start);
  comes_at_ = now;
}

bool Replica::catch_up(Tick most) {
  for (; most > 0 && now() < comes_at_; --most) agreed_.step();
  note_time();
  if (now() < comes_at_) return false;
  agreed_.catch_up();
  roster_.excuse_silence();
  adopt();
  return true;
}

}  // namespace padr::node
