#include "common/reckoning/live_world.h"

#include <algorithm>

#include "common/world/avatar_control.h"
#include "common/world/bounding_radius.h"

namespace padr::sync {
namespace {

/// Who touched whom in the step that led there. A touch may be over in the step that it begins in.
void take_touching(const world::View& after, std::vector<Contact>& out) {
  out = after.contacts();
  for (const std::uint32_t key : after.snapshot().parted)
    if (world::second_of(key) < after.entities()) out.push_back({world::first_of(key), world::second_of(key)});
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

}  // namespace

LiveWorld::LiveWorld(const Scene& scene, const FoldState& start, PeerId self, bool authority)
    : world_(scene, static_cast<int>(start.avatars.size())),
      view_(world_.scene(), world_.slots()),
      self_(self),
      authority_(authority),
      avatars_(start.avatars.size()),
      holds_(scene.bodies.size(), 0),
      reach_(world::reaches(scene, world_.slots())),
      out_(reach_.size(), true),
      keep_(reach_.size(), true) {
  for (PeerId p = 0; p < world_.slots(); ++p) world_.set_free(p, p == self || !authority);
  for (EntityId b = 0; b < world_.bodies(); ++b) world_.set_present(b, false);
  view_.change().contacts.reserve(world_.usual_contacts());
  touching_.reserve(world_.usual_contacts());
  adopt(start, std::vector<bool>(reach_.size(), false), true);
  touching_ = view_.contacts();
}

void LiveWorld::take_tables(const FoldState& predicted) {
  tick_ = predicted.tick;
  avatars_ = predicted.avatars;
  residents_ = predicted.residents;
  for (EntityId b = 0; b < residents_.slots.size(); ++b) view_.set_present(b, residents_.slots[b].present);
  for (PeerId p = 0; p < world_.slots(); ++p) view_.set_present(world_.avatar(p), avatars_[p].present);
  if (holds_ == predicted.holds) return;
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    if (holds_[b] == predicted.holds[b]) continue;
    holds_[b] = predicted.holds[b];
    for (PeerId p = 0; p < world_.slots(); ++p) world_.set_hold(p, b, (holds_[b] & only(p)) != 0);
  }
}

void LiveWorld::adopt(const FoldState& predicted, const std::vector<bool>& own, bool same, bool as_stepped) {
  take_tables(predicted);
  same_ = same;
  own_.clear();
  jumps_.clear();
  for (EntityId e = 0; e < own.size(); ++e)
    if (own[e]) own_.push_back(e);
  const auto is_taken_over = [&](EntityId e) { return same || !own[e]; };
  if (as_stepped) {
    for (const std::vector<EntityId>* some : {&stepped_, &changed_})
      for (const EntityId e : *some)
        if (is_taken_over(e)) adopt_entity(e, predicted.world.entities[e]);
  } else {
    for (EntityId e = 0; e < own.size(); ++e)
      if (is_taken_over(e)) adopt_entity(e, predicted.world.entities[e]);
  }
  changed_.clear();
  world::Snapshot& what = view_.change();
  what.contacts = predicted.world.contacts;
  what.parted = predicted.world.parted;
}

void LiveWorld::adopt_entity(EntityId e, const world::Kinematics& there) {
  world::Kinematics& here = view_.change().entities[e];
  if (here.position != there.position) jumps_.push_back({e, here.position - there.position});
  here = there;
}

void LiveWorld::take(EntityId e) {
  if (!out_[e] || !view_.present(e)) return;
  out_[e] = false;
  stepped_.push_back(e);
}

bool LiveWorld::may_touch(EntityId own, EntityId other) const {
  if (world_.is_avatar(own) || !world_.is_avatar(other) || !authority_) return true;
  const auto p = static_cast<PeerId>(other - world_.bodies());
  return p == self_ || (holds_[own] & only(p)) != 0;
}

void LiveWorld::gather_near() {
  world::BoundingBox box;
  near_.clear();
  for (const EntityId e : own_) {
    near_.push_back({e, view_.position(e), reach_[e]});
    box.enclose(view_.position(e), reach_[e]);
  }
  const std::vector<world::Kinematics>& all = view_.kinematics();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Vec2 there = all[i].position;
    if (box.is_clear_of(there, reach_[i])) continue;
    const auto e = static_cast<EntityId>(i);
    const auto is_near = [&](const Placed& own) {
      return world::within_reach(own.at, own.reach, there, reach_[i]) && may_touch(own.entity, e);
    };
    if (out_[e] && std::any_of(near_.begin(), near_.end(), is_near)) take(e);
  }
}

bool LiveWorld::join(EntityId a, EntityId b) {
  if (b >= out_.size() || out_[a] == out_[b]) return false;  // fixed, or both or neither
  const std::size_t before = stepped_.size();
  take(out_[a] ? a : b);
  return stepped_.size() > before;
}

bool LiveWorld::gather_touching(const std::vector<world::ContactState>& contacts) {
  bool found = false;
  for (const world::ContactState& c : contacts) found = join(world::first_of(c.key), world::second_of(c.key)) || found;
  return found;
}

// Who touched whom at the end of the last step, here or as predicted, and in the step that predicted has just made.
void LiveWorld::gather(const FoldState& predicted) {
  before_.swap(stepped_);
  stepped_.clear();
  out_.assign(out_.size(), true);
  for (const EntityId e : own_) take(e);
  gather_near();
  for (bool found = true; found;) {
    found = gather_touching(view_.snapshot().contacts);
    found = gather_touching(predicted.world.contacts) || found;
    for (const std::uint32_t key : predicted.world.parted)
      found = join(world::first_of(key), world::second_of(key)) || found;
    for (const Contact& c : world_.contacts()) found = join(c.first, c.second) || found;
  }
}

// What is own and was stepped before goes on as it is, unless it is as predicted anyway.
void LiveWorld::enter() {
  keep_ = out_;
  if (!same_)
    for (const EntityId e : own_) keep_[e] = world_.present(e) || out_[e];
  for (const EntityId e : before_)
    if (out_[e]) world_.set_present(e, false);
  taken_.clear();
  for (const EntityId e : stepped_) {
    world_.set_present(e, true);
    if (!keep_[e]) taken_.push_back(e);
  }
  world_.restore_only(view_.snapshot(), taken_, keep_);
}

void LiveWorld::step(Vec2 target, const FoldState& predicted) {
  advance(target, predicted);
}

void LiveWorld::step_led(const FoldState& predicted) {
  advance(std::nullopt, predicted);
}

void LiveWorld::place(const BodyState& s) {
  changed_.push_back(avatar());
  world::Kinematics& k = view_.change().entities[avatar()];
  k = {s.position, s.angle, s.velocity, s.spin, s.awake ? 0 : k.sleep_time, s.awake};
  if (world_.present(avatar())) world_.set_state(avatar(), s);
}

void LiveWorld::jolt(Vec2 velocity) {
  place_moving(avatar(), view_.velocity(avatar()) + velocity);
}

void LiveWorld::advance(std::optional<Vec2> target, const FoldState& predicted) {
  if (!predicted.start.reached(tick_)) {
    ++tick_;
    return;
  }
  gather(predicted);
  enter();
  for (const EntityId e : stepped_) {
    if (!world_.is_avatar(e)) continue;
    const auto p = static_cast<PeerId>(e - world_.bodies());
    if (p == self_ && avatars_[p].present) {
      if (target) world::drive_avatar(world_, p, *target);
    } else {
      drive_model(world_, p, avatars_[p], tick_);
    }
  }
  world_.step();
  ++tick_;
  look(predicted);
  take_touching(view_, touching_);
}

void LiveWorld::look(const FoldState& predicted) {
  world::Snapshot& what = view_.change();
  what = predicted.world;
  for (const EntityId e : stepped_) what.entities[e] = world_.kinematics(e);
  if (stepped_.empty()) return;
  world_.save_contacts(mine_);
  world::replace_contacts(what, mine_, out_);
}

void LiveWorld::push(EntityId b, Vec2 velocity) {
  constexpr float kMost = 60;  // m/s
  place_moving(b, clamp_length(view_.velocity(b) + velocity, kMost));
}

void LiveWorld::place_moving(EntityId b, Vec2 v) {
  changed_.push_back(b);
  world::Kinematics& k = view_.change().entities[b];
  k.velocity = v;
  if (v == Vec2{}) return;
  k.awake = true;
  k.sleep_time = 0;
  if (world_.present(b)) world_.set_velocity(b, v);
}

void LiveWorld::rest(EntityId e, const BodyState& s) {
  changed_.push_back(e);
  if (world_.present(e)) {
    world_.set_state(e, s);
    view_.change().entities[e] = world_.kinematics(e);
  } else {
    view_.change().entities[e] = {s.position, s.angle, {}, 0, 0, false};
  }
}

void LiveWorld::settle(const Bundle& told) {
  if (told.avatar && !told.avatar->awake) rest(avatar(), {told.avatar->position, 0, {}, 0, false});
  for (const BodyUpdate& u : told.bodies)
    if (u.has_state && !u.state.awake) rest(u.body, u.state);
}

}  // namespace padr::sync
