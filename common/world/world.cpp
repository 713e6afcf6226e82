#include "common/world/world.h"

#include <box2d/box2d.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "common/world/body_list.h"
#include "common/world/box2d_access.h"
#include "common/world/box2d_body.h"
#include "common/world/box2d_math.h"
#include "common/world/box2d_timer.h"
#include "common/world/contact_memory.h"
#include "common/world/contact_order.h"

namespace padr::world {
namespace {

/// Of a contact with one that is kept, the memory is kept.
bool is_kept(const std::vector<bool>& keep, std::uint32_t key) {
  const auto kept = [&keep](EntityId slot) { return slot < keep.size() && keep[slot]; };
  return kept(first_of(key)) || kept(second_of(key));
}

constexpr std::size_t kFewContacts = 32;
constexpr float kTurn = 6.2831853F;  // rad

}  // namespace

/// Owns the Box2D world and answers its question which pairs may collide.
struct World::Box2d final : b2ContactFilter {
  explicit Box2d(const Scene& scene) : world(to_b2(scene.gravity)) {
    world.SetWarmStarting(scene.warm_starting);
    world.SetContinuousPhysics(scene.continuous);
    world.SetContactFilter(this);
    assert(box2d_timers_stand_still());
    take_portable_math();
    // A world's very first step never warm-starts; an empty one makes all worlds alike from tick 0 on.
    world.Step(kTickSeconds, 1, 1);
  }

  bool may_collide(std::size_t a, std::size_t b) const {
    if (a > b) std::swap(a, b);
    if (!present[a] || !present[b]) return false;
    const bool avatar_and_body = a < n_bodies && b >= n_bodies && b < bodies.size();
    if (!avatar_and_body) return true;
    const PeerSet bit = only(static_cast<PeerId>(b - n_bodies));
    return ((free_avatars | holds[a]) & bit) != 0;
  }

  bool ShouldCollide(b2Fixture* a, b2Fixture* b) override {
    in_order = false;
    return may_collide(a->GetBody()->GetUserData().pointer, b->GetBody()->GetUserData().pointer);
  }

  void refilter(std::size_t e) const { bodies[e]->GetFixtureList()->Refilter(); }

  /// What has been done to this one shows, and the next step sees it.
  void changed(std::size_t e) {
    const b2Body& b = *bodies[e];
    seen[e] = {from_b2(b.GetPosition()),
               b.GetAngle() + 0.0F,
               from_b2(b.GetLinearVelocity()),
               b.GetAngularVelocity() + 0.0F,
               b.*member(access::SleepTime{}) + 0.0F,
               b.IsAwake()};
    if (b.IsAwake()) list.woken(e);
    contacts_known = false;
  }

  void find_and_order();
  bool forget_if_apart(b2Contact& c);
  void forget_forbidden(b2Body& body);
  void look_after_step();
  const std::vector<ContactState>& remembered();
  void restore_entity(std::size_t e, const Kinematics& k);
  void wake_and_forget(b2Contact& c);
  b2Contact* find(std::uint32_t key) const;
  void forget_unless(const std::vector<bool>& keep, b2Contact& c);
  void restore_contacts(const Snapshot& s, const std::vector<bool>& keep);

  b2World world;
  std::size_t n_bodies = 0;
  std::vector<b2Body*> bodies;   // by slot: bodies, avatars; fixed things have later slots and are not listed
  std::vector<Kinematics> seen;  // by slot: as it is in Box2D
  BodyList list;
  std::vector<char> present;   // by slot, fixed things included
  std::vector<PeerSet> holds;  // by body: whose avatars hold it
  PeerSet free_avatars = 0;
  mutable std::vector<Contact> contacts;
  mutable bool contacts_known = false;
  mutable std::vector<b2Contact*> scratch;
  bool in_order = false;  // all contacts, by key
  // What contacts remember, by key, while it is known: in Box2D it lies about in memory, and what sleeps stays as it
  // is.
  std::vector<ContactState> memory;
  bool memory_known = false;
  std::vector<std::uint32_t> parted;  // keys: touched in the last step and parted in it
};

World::World(const Scene& scene, int slots)
    : impl_(std::make_unique<Box2d>(scene)), scene_(std::make_unique<Scene>(scene)) {
  assert(slots >= 0 && slots <= kMaxPeers && static_cast<std::size_t>(slots) <= scene.avatar.spawns.size());
  bodies_ = static_cast<int>(scene.bodies.size());
  slots_ = slots;
  reach_ = around(scene, kMostOutside);
  Box2d& w = *impl_;
  w.n_bodies = scene.bodies.size();
  const std::size_t total = w.n_bodies + static_cast<std::size_t>(slots) + scene.statics.size();
  assert(total < kNoEntity);
  w.present.assign(total, 1);
  w.holds.assign(w.n_bodies, 0);
  for (const BodyDef& d : scene.bodies) w.bodies.push_back(create_body(w.world, d, b2_dynamicBody, w.bodies.size()));
  const AvatarDef& a = scene.avatar;
  for (int p = 0; p < slots; ++p) {
    BodyDef d;
    d.shape = ShapeKind::kCircle;
    d.radius = a.radius;
    d.mass = a.mass;
    d.friction = a.friction;
    d.restitution = a.restitution;
    d.position = a.spawns[static_cast<std::size_t>(p)];
    w.present[w.bodies.size()] = 0;
    b2Body* body = create_body(w.world, d, b2_dynamicBody, w.bodies.size(), true);
    body->SetGravityScale(a.gravity ? 1.0F : 0.0F);
    body->SetAwake(false);
    w.bodies.push_back(body);
  }
  std::size_t slot = w.bodies.size();
  for (const BodyDef& d : scene.statics) create_body(w.world, d, b2_staticBody, slot++);
  w.seen.resize(w.bodies.size());
  seen_ = w.seen.data();
  w.memory.reserve(usual_contacts());
  w.list.begin(w.world, w.bodies);
  for (std::size_t e = 0; e < w.bodies.size(); ++e) w.changed(e);
}

World::~World() {
  impl_->list.end();
}

void World::set_present(EntityId e, bool present) {
  if ((impl_->present[e] != 0) == present) return;
  impl_->present[e] = present ? 1 : 0;
  impl_->refilter(e);
  impl_->forget_forbidden(*impl_->bodies[e]);
  if (!present) impl_->bodies[e]->SetAwake(false);
  impl_->changed(e);
}

bool World::present(EntityId e) const {
  return impl_->present[e] != 0;
}

void World::set_hold(PeerId p, EntityId body, bool held) {
  PeerSet& mask = impl_->holds[body];
  const PeerSet bit = only(p);
  if (((mask & bit) != 0) == held) return;
  mask ^= bit;
  impl_->refilter(avatar(p));
  impl_->forget_forbidden(*impl_->bodies[avatar(p)]);
}

bool World::hold(PeerId p, EntityId body) const {
  return (impl_->holds[body] & only(p)) != 0;
}

void World::set_free(PeerId p, bool free) {
  const PeerSet bit = only(p);
  if (((impl_->free_avatars & bit) != 0) == free) return;
  impl_->free_avatars ^= bit;
  impl_->refilter(avatar(p));
  impl_->forget_forbidden(*impl_->bodies[avatar(p)]);
}

void World::set_state(EntityId e, const BodyState& s) {
  const BodyState now = state(e);
  if (now == s) return;
  b2Body& b = *impl_->bodies[e];
  if (now.position != s.position || now.angle != s.angle) {
    b.SetTransform(to_b2(s.position), s.angle);
    b.SetAwake(true);
    for (b2ContactEdge* c = b.GetContactList(); c != nullptr; c = c->next) impl_->forget_if_apart(*c->contact);
  }
  if (s.awake) {
    b.SetAwake(true);
    b.SetLinearVelocity(to_b2(s.velocity));
    b.SetAngularVelocity(s.spin);
  } else {
    b.SetAwake(false);
  }
  impl_->changed(e);
}

void World::set_velocity(EntityId e, Vec2 v) {
  impl_->bodies[e]->SetLinearVelocity(to_b2(v));
  impl_->changed(e);
}

void World::apply_force(EntityId e, Vec2 force) {
  impl_->bodies[e]->ApplyForceToCenter(to_b2(force), true);
  if (!impl_->seen[e].awake) impl_->changed(e);
}

std::size_t World::listed() const {
  return impl_->list.listed().size();
}

void World::step() {
  Box2d& w = *impl_;
  w.parted.clear();
  w.find_and_order();
  w.list.prepare();
  if (w.list.listed().empty()) return;  // all sleeps, and stays as it is
  w.world.Step(kTickSeconds, scene_->velocity_iterations, scene_->position_iterations);
  w.look_after_step();
  for (const std::uint32_t e : w.list.listed()) w.changed(e);
  for (const std::uint32_t e : w.list.listed()) keep_in_reach(static_cast<EntityId>(e));
  w.contacts_known = false;
}

// A scene need not have walls all round. What fell for ever would be refused by whoever is told of it, and nobody could
// take over a world that it is in.
void World::keep_in_reach(EntityId e) {
  BodyState s = state(e);
  const Vec2 place{std::clamp(s.position.x, reach_.lower.x, reach_.upper.x),
                   std::clamp(s.position.y, reach_.lower.y, reach_.upper.y)};
  if (place == s.position && std::abs(s.angle) <= kMostAngle) return;
  if (place.x != s.position.x) s.velocity.x = 0;
  if (place.y != s.position.y) s.velocity.y = 0;
  s.position = place;
  if (std::abs(s.angle) > kMostAngle) s.angle -= kTurn * static_cast<float>(static_cast<int>(s.angle / kTurn));
  set_state(e, s);
}

// New contacts come with the question whether they may be; without any the order still holds.
void World::Box2d::find_and_order() {
  find_contacts(world);
  if (in_order) return;
  order_contacts(world, scratch);
  in_order = true;
}

// Contacts of what is not listed are as they were.
void World::Box2d::look_after_step() {
  const bool others_known = memory_known;
  const auto is_touched = [this](EntityId slot) { return slot < bodies.size() && list.is_listed(slot); };
  std::erase_if(memory,
                [&](const ContactState& c) { return is_touched(first_of(c.key)) || is_touched(second_of(c.key)); });
  scratch.clear();
  for (const std::uint32_t slot : list.listed())
    for (b2ContactEdge* e = bodies[slot]->GetContactList(); e != nullptr; e = e->next) {
      const std::uint32_t other = slot_of(*e->other);
      const bool twice = other < slot && is_touched(static_cast<EntityId>(other));
      if (!twice && remembers(*e->contact)) scratch.push_back(e->contact);
    }
  std::sort(scratch.begin(), scratch.end(),
            [](const b2Contact* a, const b2Contact* b) { return contact_key(*a) < contact_key(*b); });
  for (b2Contact* c : scratch) {
    if (forget_if_apart(*c)) {
      parted.push_back(contact_key(*c));
    } else if (others_known) {
      read_contact(*c, memory.emplace_back());
    }
  }
  memory_known = others_known;
  if (memory_known) sort_by_key(memory);
}

const std::vector<ContactState>& World::Box2d::remembered() {
  if (memory_known) return memory;
  memory.clear();
  for (b2Contact* c = world.GetContactList(); c != nullptr; c = c->GetNext())
    if (remembers(*c)) read_contact(*c, memory.emplace_back());
  sort_by_key(memory);
  memory_known = true;
  return memory;
}

void World::Box2d::wake_and_forget(b2Contact& c) {
  forget_contact(c);
  memory_known = false;
  for (b2Body* b : {c.GetFixtureA()->GetBody(), c.GetFixtureB()->GetBody()}) {
    b->SetAwake(true);
    if (const std::size_t e = b->GetUserData().pointer; e < bodies.size()) changed(e);
  }
}

// Box2D drops a contact, and wakes its two bodies, when their enlarged bounds part, which happens at a moment that
// depends on history. Doing the same when the true bounds part comes earlier always, so Box2D's own never matters.
bool World::Box2d::forget_if_apart(b2Contact& c) {
  if (!remembers(c)) return false;
  const b2Body& a = *c.GetFixtureA()->GetBody();
  const b2Body& b = *c.GetFixtureB()->GetBody();
  if (!a.IsAwake() && !b.IsAwake()) return false;
  if (bounds_overlap(c)) return false;
  wake_and_forget(c);
  return true;
}

// The same for a contact that has just become forbidden: now, not whenever Box2D next looks at it.
void World::Box2d::forget_forbidden(b2Body& body) {
  for (b2ContactEdge* e = body.GetContactList(); e != nullptr; e = e->next)
    if (remembers(*e->contact) && !may_collide(body.GetUserData().pointer, e->other->GetUserData().pointer))
      wake_and_forget(*e->contact);
}

const std::vector<Contact>& World::contacts() const {
  Box2d& w = *impl_;
  if (w.contacts_known) return w.contacts;
  w.contacts.clear();
  for (const ContactState& c : w.remembered())
    if (c.touching && second_of(c.key) < w.bodies.size()) w.contacts.push_back({first_of(c.key), second_of(c.key)});
  w.contacts_known = true;
  return w.contacts;
}

void World::save(Snapshot& out) const {
  out.entities = impl_->seen;
  save_contacts(out);
}

std::size_t World::usual_contacts() const {
  return std::max(kFewContacts, impl_->bodies.size());
}

void World::save_contacts(Snapshot& out) const {
  out.parted = impl_->parted;
  out.contacts.reserve(usual_contacts());
  out.contacts = impl_->remembered();
}

void World::Box2d::restore_entity(std::size_t e, const Kinematics& k) {
  if (seen[e] == k) return;
  b2Body& b = *bodies[e];
  if (seen[e].position != k.position || seen[e].angle != k.angle) b.SetTransform(to_b2(k.position), k.angle);
  if (k.awake) {
    if (!b.IsAwake()) b.SetAwake(true);
    b.SetLinearVelocity(to_b2(k.velocity));
    b.SetAngularVelocity(k.spin);
  } else if (b.IsAwake()) {
    b.SetAwake(false);
  }
  b.*member(access::SleepTime{}) = k.sleep_time;
  changed(e);
}

b2Contact* World::Box2d::find(std::uint32_t key) const {
  const EntityId first = first_of(key);
  const EntityId second = second_of(key);
  for (b2ContactEdge* e = bodies[first]->GetContactList(); e != nullptr; e = e->next)
    if (e->other->GetUserData().pointer == second) return e->contact;
  return nullptr;
}

void World::Box2d::forget_unless(const std::vector<bool>& keep, b2Contact& c) {
  if (!is_kept(keep, contact_key(c))) forget_contact(c);
}

void World::Box2d::restore_contacts(const Snapshot& s, const std::vector<bool>& keep) {
  find_contacts(world);
  for (const ContactState& state : s.contacts)
    if (!is_kept(keep, state.key))
      if (b2Contact* c = find(state.key)) write_contact(*c, state);
  parted.clear();
  contacts_known = false;
  memory_known = false;
}

void World::restore(const Snapshot& s, const std::vector<bool>& keep) {
  Box2d& w = *impl_;
  assert(s.entities.size() == w.bodies.size());
  for (std::size_t e = 0; e < w.bodies.size(); ++e)
    if (e >= keep.size() || !keep[e]) w.restore_entity(e, s.entities[e]);
  for (b2Contact* c = w.world.GetContactList(); c != nullptr; c = c->GetNext())
    if (remembers(*c)) w.forget_unless(keep, *c);
  w.restore_contacts(s, keep);
}

void World::restore_only(const Snapshot& s, const std::vector<EntityId>& which, const std::vector<bool>& keep) {
  Box2d& w = *impl_;
  for (const EntityId e : which) {
    w.restore_entity(e, s.entities[e]);
    for (b2ContactEdge* c = w.bodies[e]->GetContactList(); c != nullptr; c = c->next)
      if (remembers(*c->contact)) w.forget_unless(keep, *c->contact);
  }
  w.restore_contacts(s, keep);
}

}  // namespace padr::world
