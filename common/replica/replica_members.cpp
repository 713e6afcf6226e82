// A Replica's part in membership: its own admission, and the admissions and removals of others.
#include <algorithm>
#include <utility>

#include "common/model/observed_address.h"
#include "common/replica/replica.h"

namespace padr::node {
void Replica::file(const sync::Bundle& bundle) {
  if (!agreed_.insert(bundle)) return;
  news_ = now();
  note_changes(bundle);
}

// Acted upon as soon as it is heard, not when it is confirmed: nothing can be confirmed before those are asked who must
// be. What is heard out of order is put right by the incarnation.
void Replica::note_changes(const sync::Bundle& b) {
  for (const sync::Bundle& lost : b.passed_on) file(lost);
  for (const sync::Removal& r : b.removals) remove(r, b);
  if (b.admission) admit(*b.admission, b);
  if (!b.leave) return;
  Neighbour& n = others_[b.peer];
  const bool of_before = b.index < (b.peer == config_.self && member_ ? own_first_ : n.first);
  if (of_before) return;  // somebody else sits there already
  agreed_.close(b.peer, b.index + 1);
  if (b.peer == config_.self || !n.there()) return;
  n.presence = Presence::kLeft;
  n.frozen = false;
  n.held.clear();
  changes_.push_back({MemberChange::Kind::kLeft, b.peer, n.incarnation, n.at, b.tick, b.peer});
}

// Where who said the update was then; not set if that is not known, or if it was this peer.
Endpoint Replica::place_of_sayer(const sync::Bundle& said) const {
  const Neighbour& n = others_[said.peer];
  if (said.peer == config_.self && member_ && said.index >= n.first) return {};
  if (said.index >= n.first) return n.at;
  for (auto f = n.former.rbegin(); f != n.former.rend(); ++f)
    if (said.index >= f->first) return f->at;
  return {};
}

void Replica::admit(const sync::Admission& a, const sync::Bundle& by) {
  Neighbour& n = others_[a.slot];
  if (a.slot == config_.self) {
    if (a.incarnation > config_.incarnation) expelled_ = true;
    if (a.incarnation != config_.incarnation || member_) return;
    agreed_.close(a.slot, a.first);
    agreed_.enter(by.tick);
    own_first_ = a.first;
    n.former = {{n.first, n.incarnation, n.at}};
    n.first = a.first;
    member_ = true;
    in_since_ = by.tick;
    if (by.peer != config_.self) admitted_by_ = by.peer;
    for (Neighbour& other : others_) {
      other.link = sync::OutLink(a.first);
      other.heard = other.answered = other.excused = now();
    }
    changes_.push_back({MemberChange::Kind::kAdmitted, a.slot, a.incarnation, a.at, by.tick, by.peer});
    return;
  }
  if (a.incarnation <= n.incarnation) return;
  const Endpoint at = as_seen_from(a.at, place_of_sayer(by));
  agreed_.close(a.slot, a.first);  // should the removal of who sat there before come later
  agreed_.open(a.slot, by.tick);
  repeats_of_gone_ += n.link.repeats();
  std::vector<Former> former = std::move(n.former);
  if (former.size() == Neighbour::kFormer) former.erase(former.begin());
  former.push_back({n.first, n.incarnation, n.at});
  const auto dropped = n.dropped;
  n = Neighbour{};
  n.former = std::move(former);
  n.dropped = dropped;
  n.presence = Presence::kThere;
  n.incarnation = a.incarnation;
  n.first = a.first;
  n.at = at;
  n.link = sync::OutLink(a.have[config_.self]);
  n.heard = n.answered = n.excused = now();
  n.since = by.tick;
  n.confirmed = agreed_.confirmed().tick;
  changes_.push_back({MemberChange::Kind::kAdmitted, a.slot, a.incarnation, at, by.tick, by.peer});
}

void Replica::remove(const sync::Removal& r, const sync::Bundle& by) {
  if (r.slot == config_.self) {
    if (r.incarnation == config_.incarnation) expelled_ = true;
    if (!member_) agreed_.close(r.slot, r.count);  // of who sat there before
    return;
  }
  Neighbour& n = others_[r.slot];
  if (r.incarnation != n.incarnation || !n.reachable()) return;
  if (agreed_.log().have(r.slot) > r.count) expelled_ = true;  // they agreed without us
  agreed_.close(r.slot, r.count);
  n.frozen = false;
  n.held.clear();
  if (!n.there()) return;  // it has left: its farewell was the end, and counts
  n.presence = Presence::kAbsent;
  changes_.push_back({MemberChange::Kind::kRemoved, r.slot, r.incarnation, n.at, by.tick, by.peer});
}

// How many of its updates are here must not grow any more: not by datagrams, and not by what others pass on to close a
// hole beyond which there is more.
void Replica::freeze(PeerId p, bool frozen) {
  Neighbour& n = others_[p];
  if (n.frozen == frozen) return;
  n.frozen = frozen;
  if (frozen) {
    n.held = agreed_.hold(p);
  } else {
    for (const sync::Bundle& b : std::exchange(n.held, {})) file(b);
  }
}

std::uint32_t Replica::newest_incarnation() const {
  std::uint32_t newest = config_.incarnation;
  for (const Neighbour& n : others_) newest = std::max(newest, n.incarnation);
  return newest;
}

std::vector<MemberChange> Replica::take_changes() {
  return std::exchange(changes_, {});
}

void Replica::excuse_silence() {
  for (Neighbour& n : others_) {
    n.heard = n.answered = n.excused = now();
    n.given_up = -1;
    n.given_up_for_good = n.proven = false;
  }
}

sync::Transfer Replica::transfer() const {
  sync::Transfer t;
  t.state = agreed_.confirmed();
  t.tail = agreed_.log().since(t.state.tick);
  // Without what lies beyond holes: a removal might close one that the newcomer is never told of otherwise.
  std::erase_if(t.tail, [&](const sync::Bundle& b) { return b.index >= agreed_.log().have(b.peer); });
  t.slots.resize(others_.size());
  t.have.resize(others_.size());
  for (PeerId p = 0; p < others_.size(); ++p) {
    const Neighbour& n = others_[p];
    t.slots[p] = {agreed_.log().have(p), n.at};
    t.have[p] = agreed_.log().have(p);
  }
  for (const sync::Bundle& b : t.tail) t.slots[b.peer].first = std::min(t.slots[b.peer].first, b.index);
  return t;
}

// Who sent the transfer knows where everybody is. The updates in it tell where somebody was seen by a coordinator who
// may have gone, and whose slot may be another's by now.
void Replica::keep_places(const sync::Transfer& start) {
  for (PeerId p = 0; p < others_.size(); ++p)
    if (p != config_.self && start.slots[p].at.is_set()) others_[p].at = start.slots[p].at;
  for (MemberChange& c : changes_)
    if (c.slot != config_.self) c.at = others_[c.slot].at;
}

Replica::Replica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start, Tick now,
                 ConfirmedSink on_confirmed)
    : Replica(scene, config, start, std::move(on_confirmed), Later{}) {
  for (PeerId p = 0; p < config.slots; ++p) {
    const sync::Transfer::Slot& s = start.slots[p];
    Neighbour& n = others_[p];
    const sync::Member& member = start.state.members[p];
    // Who is there in the state may have gone since: then the tail says so.
    n.incarnation = member.incarnation;
    n.at = s.at;
    n.confirmed = n.heard = n.answered = start.state.tick;
    if (member.present) n.presence = Presence::kThere;
  }
  for (const sync::Bundle& b : start.tail) file(b);
  keep_places(start);
  comes_at_ = now;
}

bool Replica::catch_up(Tick most) {
  for (; most > 0 && now() < comes_at_; --most) agreed_.step();
  if (now() < comes_at_) return false;
  agreed_.catch_up();
  excuse_silence();
  adopt();
  return true;
}

}  // namespace padr::node
