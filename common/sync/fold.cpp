#include "common/sync/fold.h"

#include <algorithm>

namespace padr::sync {

Fold::Fold(const Scene& scene, int slots, int peers, bool authority, int wanted)
    : world_(scene, slots),
      with_authority_(authority),
      start_{wanted, 0},
      members_(static_cast<std::size_t>(slots)),
      avatars_(static_cast<std::size_t>(slots)),
      authority_(scene.bodies.size()),
      holds_(scene.bodies.size(), 0),
      residents_(residents_of(scene)) {
  for (EntityId b = 0; b < residents_.slots.size(); ++b) world_.set_present(b, residents_.slots[b].present);
  for (PeerId p = 0; p < peers; ++p) {
    members_[p].present = true;
    avatars_[p].present = true;
    world_.set_present(world_.avatar(p), true);
  }
  if (authority) return;
  for (PeerId p = 0; p < slots; ++p) world_.set_free(p, true);
}

void Fold::apply(const Bundle& bundle, Tick told) {
  if (!members_[bundle.peer].present) return;
  if (bundle.leave) return remove(bundle.peer);
  if (bundle.spectates) return remove_avatar(bundle.peer);
  for (const Removal& r : bundle.removals)
    if (members_[r.slot].present && members_[r.slot].incarnation == r.incarnation) remove(r.slot);
  if (bundle.admission) admit(*bundle.admission, bundle.tick);
  if (bundle.going && world_.scene().region) members_[bundle.peer].going = *bundle.going;
  for (const Passage& p : bundle.passages) pass(bundle.peer, p, bundle.tick);
  const bool spectates = !avatars_[bundle.peer].present && !world_.scene().region;
  if (spectates) return;
  if (bundle.avatar) apply_avatar(bundle.peer, *bundle.avatar, bundle.tick);
  for (const BodyUpdate& u : bundle.bodies) apply_body(bundle.peer, u, told);
}

void Fold::apply_avatar(PeerId p, const AvatarUpdate& u, Tick tick) {
  AvatarModel& m = avatars_[p];
  m = {true, u.model, u.velocity, u.control, tick, !u.awake};
  if (!plays(world_.avatar(p))) return;
  world_.set_present(world_.avatar(p), true);
  world_.set_state(world_.avatar(p), {u.position, 0, u.velocity, 0, u.awake});
}

void Fold::apply_body(PeerId p, const BodyUpdate& u, Tick told) {
  if (!with_authority_) return;
  set_hold(p, u.body, u.held);
  if (!u.has_state) {
    if (u.release && authority_[u.body].owner == p) authority_[u.body].released = true;
    return;
  }
  Authority claim{p, u.release, u.epoch, u.claimed};
  const Authority& present = authority_[u.body];
  if (!may_rest_on(claim, present, told) || !wins(claim, present, u.body)) return;
  authority_[u.body] = claim;
  if (plays(u.body)) world_.set_state(u.body, u.state);
}

// By the tick of the admission, so that play begins at the same one wherever it is heard of. Whoever has the slot until
// then gives way to a newer incarnation, as in the roster: with another occupant here than there, nobody could be
// removed.
void Fold::admit(const Admission& a, Tick tick) {
  if (a.incarnation <= members_[a.slot].incarnation) return;
  if (members_[a.slot].present) remove(a.slot);
  members_[a.slot] = {true, a.incarnation, false};
  avatars_[a.slot] = {};
  // In a region its owner first has to say where it is.
  avatars_[a.slot].present = !world_.scene().region && !a.spectator;
  const EntityId e = world_.avatar(a.slot);
  world_.set_state(e, {world_.scene().avatar.spawns[a.slot], 0, {}, 0, true});
  world_.set_present(e, avatars_[a.slot].present);
  const auto players = std::count_if(avatars_.begin(), avatars_.end(), [](const AvatarModel& m) { return m.present; });
  if (start_.wanted > 0 && players >= start_.wanted) start_ = {0, tick + kStartLead};
}

// Who enters a slot begins with a record that nothing said of whoever was there before can beat.
void Fold::pass(PeerId p, const Passage& passage, Tick tick) {
  if (!world_.scene().region) return;
  if (passage.kind == Passage::Kind::kBound) {
    const auto found = residents_.slot_of(passage);
    if (found && residents_.slots[*found].bound == 0) residents_.slots[*found].bound = passage.to;
    return;
  }
  if (passage.kind == Passage::Kind::kOut) {
    const auto left = residents_.slot_of(passage);
    if (left) leave_free(*left);
    residents_.note_gone(passage, tick_);
    return;
  }
  const auto b = residents_.slot_for(passage, *world_.scene().region);
  if (!b) return;
  leave_free(*b);
  residents_.slots[*b] = {true, passage.name, passage.crossings, 0};
  authority_[*b] = {p, !passage.owned || !with_authority_, authority_[*b].epoch + 1, tick};
  world_.set_present(*b, true);
  world_.set_state(*b, passage.state);
}

void Fold::leave_free(EntityId body) {
  for (PeerId p = 0; p < world_.slots(); ++p) set_hold(p, body, false);
  residents_.slots[body] = {};
  if (authority_[body].owner != kNoPeer) authority_[body].released = true;
  world_.set_present(body, false);
  const BodyDef& d = world_.scene().bodies[body];
  world_.set_state(body, {d.position, d.angle, {}, 0, false});
}

void Fold::remove(PeerId p) {
  members_[p].present = false;
  members_[p].going = false;
  remove_avatar(p);
}

// What it owned goes on by physics alone, for everybody alike, until somebody touches it.
void Fold::remove_avatar(PeerId p) {
  avatars_[p] = {};
  world_.set_present(world_.avatar(p), false);
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    set_hold(p, b, false);
    if (authority_[b].owner == p) authority_[b].released = true;
  }
}

void Fold::set_hold(PeerId p, EntityId body, bool held) {
  const PeerSet bit = only(p);
  holds_[body] = held ? (holds_[body] | bit) : (holds_[body] & ~bit);
  world_.set_hold(p, body, held);
}

void Fold::disturb(EntityId e, Vec2 by) {
  BodyState s = world_.state(e);
  s.position = s.position + by;
  world_.set_state(e, s);
}

void Fold::step() {
  if (start_.reached(tick_)) {
    for (PeerId p = 0; p < world_.slots(); ++p)
      if (plays(world_.avatar(p))) drive_model(world_, p, avatars_[p], tick_);
    world_.step();
  }
  ++tick_;
}

void Fold::save(FoldState& out) const {
  out.tick = tick_;
  out.start = start_;
  out.members = members_;
  world_.save(out.world);
  out.avatars = avatars_;
  out.authority = authority_;
  out.holds = holds_;
  out.residents = residents_;
}

void Fold::take_tables(const FoldState& s) {
  tick_ = s.tick;
  start_ = s.start;
  members_ = s.members;
  avatars_ = s.avatars;
  authority_ = s.authority;
  residents_ = s.residents;
  if (left_out_.empty()) {
    const EntityId first = residents_.slots.empty() ? world_.avatar(0) : EntityId{0};
    for (EntityId e = first; e < world_.entities(); ++e) world_.set_present(e, is_there(e));
  }
  if (holds_ == s.holds) return;
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    if (holds_[b] == s.holds[b]) continue;
    holds_[b] = s.holds[b];
    for (PeerId p = 0; p < world_.slots(); ++p) world_.set_hold(p, b, (holds_[b] & only(p)) != 0);
  }
}

void Fold::restore(const FoldState& s) {
  take_tables(s);
  world_.restore(s.world);
}

void Fold::restore_only(const FoldState& s, const std::vector<EntityId>& which, const std::vector<bool>& keep) {
  take_tables(s);
  world_.restore_only(s.world, which, keep);
}

bool Fold::is_there(EntityId e) const {
  if (world_.is_avatar(e)) return avatars_[static_cast<std::size_t>(e - world_.bodies())].present;
  return residents_.slots.empty() || residents_.slots[e].present;
}

void Fold::leave_out(const std::vector<EntityId>& in, const std::vector<bool>& out) {
  if (left_out_.empty())
    for (EntityId e = 0; e < out.size(); ++e) world_.set_present(e, false);
  left_out_ = out;
  for (const EntityId e : played_)
    if (out[e]) world_.set_present(e, false);
  played_ = in;
  for (const EntityId e : played_) world_.set_present(e, is_there(e));
}

void Fold::restore_part(const FoldState& s, const std::vector<EntityId>& in, const std::vector<bool>& out) {
  take_tables(s);
  leave_out(in, out);
  world_.restore_only(s.world, in, out);
}

}  // namespace padr::sync
