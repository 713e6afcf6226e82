#include "common/sync/fold.h"

namespace padr::sync {

Fold::Fold(const Scene& scene, int slots, int peers, bool authority)
    : world_(scene, slots),
      with_authority_(authority),
      members_(static_cast<std::size_t>(slots)),
      avatars_(static_cast<std::size_t>(slots)),
      authority_(scene.bodies.size()),
      holds_(scene.bodies.size(), 0) {
  for (PeerId p = 0; p < peers; ++p) {
    members_[p].present = true;
    avatars_[p].present = true;
    world_.set_present(world_.avatar(p), true);
  }
  if (authority) return;
  for (PeerId p = 0; p < slots; ++p) world_.set_free(p, true);
}

int Fold::apply(const Bundle& bundle) {
  if (!members_[bundle.peer].present) return 0;
  if (bundle.leave) {
    remove(bundle.peer);
    return 0;
  }
  for (const Removal& r : bundle.removals)
    if (members_[r.slot].present && members_[r.slot].incarnation == r.incarnation) remove(r.slot);
  if (bundle.admission) admit(*bundle.admission);
  if (bundle.avatar) apply_avatar(bundle.peer, *bundle.avatar, bundle.tick);
  int refused = 0;
  for (const BodyUpdate& u : bundle.bodies)
    if (!apply_body(bundle.peer, u)) ++refused;
  return refused;
}

void Fold::apply_avatar(PeerId p, const AvatarUpdate& u, Tick tick) {
  AvatarModel& m = avatars_[p];
  m = {true, u.model, u.velocity, u.control, tick, !u.awake};
  world_.set_present(world_.avatar(p), true);
  world_.set_state(world_.avatar(p), {u.position, 0, u.velocity, 0, u.awake});
}

bool Fold::apply_body(PeerId p, const BodyUpdate& u) {
  if (!with_authority_) return false;
  set_hold(p, u.body, u.held);
  if (!u.has_state) {
    if (u.release && authority_[u.body].owner == p) authority_[u.body].released = true;
    return true;
  }
  Authority claim{p, u.release, u.epoch, u.claimed};
  if (!wins(claim, authority_[u.body], u.body)) return false;
  authority_[u.body] = claim;
  world_.set_state(u.body, u.state);
  return true;
}

void Fold::admit(const Admission& a) {
  if (members_[a.slot].present || a.incarnation <= members_[a.slot].incarnation) return;
  members_[a.slot] = {true, a.incarnation};
  avatars_[a.slot] = {};
  avatars_[a.slot].present = true;
  const EntityId e = world_.avatar(a.slot);
  world_.set_state(e, {world_.scene().avatar.spawns[a.slot], 0, {}, 0, true});
  world_.set_present(e, true);
}

// What it owned goes on by physics alone, for everybody alike, until somebody touches it.
void Fold::remove(PeerId p) {
  members_[p].present = false;
  avatars_[p] = {};
  world_.set_present(world_.avatar(p), false);
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    set_hold(p, b, false);
    if (authority_[b].owner == p) authority_[b].released = true;
  }
}

void Fold::set_hold(PeerId p, EntityId body, bool held) {
  const std::uint32_t bit = 1U << p;
  holds_[body] = held ? (holds_[body] | bit) : (holds_[body] & ~bit);
  world_.set_hold(p, body, held);
}

void Fold::disturb(EntityId e, Vec2 by) {
  BodyState s = world_.state(e);
  s.position = s.position + by;
  world_.set_state(e, s);
}

void Fold::step() {
  for (PeerId p = 0; p < world_.slots(); ++p) drive_model(world_, p, avatars_[p], tick_);
  world_.step();
  ++tick_;
}

void Fold::save(FoldState& out) const {
  out.tick = tick_;
  out.members = members_;
  world_.save(out.world);
  out.avatars = avatars_;
  out.authority = authority_;
  out.holds = holds_;
}

void Fold::restore(const FoldState& s) {
  tick_ = s.tick;
  members_ = s.members;
  avatars_ = s.avatars;
  authority_ = s.authority;
  for (PeerId p = 0; p < world_.slots(); ++p) world_.set_present(world_.avatar(p), avatars_[p].present);
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    if (holds_[b] == s.holds[b]) continue;
    holds_[b] = s.holds[b];
    for (PeerId p = 0; p < world_.slots(); ++p) world_.set_hold(p, b, (holds_[b] & (1U << p)) != 0);
  }
  world_.restore(s.world);
}

std::uint64_t hash_of(const FoldState& s) {
  Hasher h;
  h.add(static_cast<std::uint64_t>(s.tick));
  world::add_to_hash(h, s.world);
  for (const Member& m : s.members)
    h.add(static_cast<std::uint64_t>(m.present) | static_cast<std::uint64_t>(m.incarnation) << 1U);
  for (const AvatarModel& m : s.avatars) {
    h.add(static_cast<std::uint64_t>(m.present) | static_cast<std::uint64_t>(m.at_rest) << 1U |
          static_cast<std::uint64_t>(m.kind) << 2U | static_cast<std::uint64_t>(m.since) << 8U);
    h.add(m.velocity.x, m.velocity.y);
    h.add(m.control.x, m.control.y);
  }
  for (std::size_t b = 0; b < s.authority.size(); ++b) {
    const Authority& a = s.authority[b];
    h.add(static_cast<std::uint64_t>(a.owner) | static_cast<std::uint64_t>(a.released) << 8U |
          static_cast<std::uint64_t>(a.epoch) << 16U);
    h.add(static_cast<std::uint64_t>(a.claimed) << 32U | s.holds[b]);
  }
  return h.value();
}

}  // namespace padr::sync
