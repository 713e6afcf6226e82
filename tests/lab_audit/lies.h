#pragma once

#include <cmath>

#include "tests/lab_audit/liar_trial.h"

namespace padr::test {

// The lies of these tests, of any size. Each is a function of the update alone, so that repeats say the same.

/// The avatar is so many metres aside from now on.
inline void teleport(LiarTrial& t, float metres) {
  const Vec2 here = t.liar().live().world().position(t.liar().live().avatar());
  const float way = here.x > 10 ? -metres : metres;
  t.tell([way](sync::Bundle& b) {
    if (b.avatar) b.avatar->position.x += way;
  });
}

/// It moves so many times as fast, from where it is now.
inline void speed_up(LiarTrial& t, float times) {
  const Vec2 here = t.liar().live().world().position(t.liar().live().avatar());
  t.tell([here, times](sync::Bundle& b) {
    if (!b.avatar) return;
    b.avatar->position = here + (b.avatar->position - here) * times;
    b.avatar->velocity = b.avatar->velocity * times;
  });
}

/// A body that nobody has to do with, as far from the liar as can be.
inline EntityId farthest_body(const LiarTrial& t) {
  const world::View& world = t.liar().live().world();
  EntityId best = 0;
  for (EntityId b = 0; b < world.bodies(); ++b)
    if (distance(world.position(b), world.position(t.liar().live().avatar())) >
        distance(world.position(best), world.position(t.liar().live().avatar())))
      best = b;
  return best;
}

inline sync::BodyUpdate claim_of(const node::Replica& liar, EntityId body, Tick tick) {
  const sync::FoldState& s = liar.agreed().predicted_state();
  sync::BodyUpdate u;
  u.body = body;
  u.has_state = true;
  u.epoch = s.authority[body].epoch + 1;
  u.claimed = tick;
  const world::Kinematics& k = s.world.entities[body];
  u.state = {k.position, k.angle, k.velocity, k.spin, k.awake};
  return u;
}

/// In place of what the next update says of bodies.
inline void tell_once(LiarTrial& t, const sync::BodyUpdate& claim) {
  t.tell([claim, told = std::optional<std::uint32_t>{}](sync::Bundle& b) mutable {
    if (!told) told = b.index;
    if (*told != b.index) return;
    sync::BodyUpdate u = claim;
    u.claimed = b.tick;
    b.bodies = {u};
  });
}

/// With one update the liar claims a body that is nowhere near.
inline void claim_far_body(LiarTrial& t, EntityId body) {
  tell_once(t, claim_of(t.liar(), body, 0));
}

/// Slot 1 is told that the liar's avatar is that far from where all others are told that it is.
inline void tell_one_otherwise(LiarTrial& t, float metres) {
  t.trial().liar().begin([metres, from = t.from()](sync::StatePacket& p, PeerId to) {
    for (sync::Bundle& b : p.updates)
      if (b.avatar && to == 1 && b.tick >= from) b.avatar->position.x += metres;
  });
}

inline EntityId nearest_body(const LiarTrial& t) {
  const world::View& world = t.liar().live().world();
  const Vec2 here = world.position(t.liar().live().avatar());
  EntityId best = 0;
  for (EntityId b = 0; b < world.bodies(); ++b)
    if (distance(world.position(b), here) < distance(world.position(best), here)) best = b;
  return best;
}

/// With one update the liar claims the body next to it, and gives it that speed.
inline void give_energy(LiarTrial& t, float speed) {
  sync::BodyUpdate claim = claim_of(t.liar(), nearest_body(t), 0);
  claim.state.velocity = {speed, 0};
  claim.state.awake = true;
  tell_once(t, claim);
}

/// The body that is farthest from all avatars but the liar's, of those that are at least so far from the liar.
inline EntityId lonely_body(const LiarTrial& t, float metres) {
  const world::View& world = t.liar().live().world();
  const auto loneliness = [&](EntityId b) {
    float least = 1000;
    for (PeerId p = 0; p < 4; ++p)
      if (p != LiarTrial::kLiar) least = std::min(least, distance(world.position(b), world.position(world.avatar(p))));
    const Vec2 liar = world.position(t.liar().live().avatar());
    return distance(world.position(b), liar) < metres ? 0 : least;
  };
  EntityId best = 0;
  for (EntityId b = 0; b < world.bodies(); ++b)
    if (loneliness(b) > loneliness(best)) best = b;
  return best;
}

/// A body that lies somewhere is next to the liar, which claims it.
inline void fetch_body(LiarTrial& t, EntityId body, float nearer) {
  const Vec2 avatar = t.liar().live().world().position(t.liar().live().avatar());
  sync::BodyUpdate claim = claim_of(t.liar(), body, 0);
  const Vec2 way = avatar - claim.state.position;
  claim.state.position = claim.state.position + way * std::min(nearer / length(way), 1.0F);
  tell_once(t, claim);
}

}  // namespace padr::test
