#include <cmath>

#include "common/model/rng.h"
#include "common/world/world.h"

namespace padr::world {
namespace {

/// Circles and tilted boxes thrown together in a small pit under gravity: friction, rotation, stacking, sleeping.
Scene canned_scene() {
  Scene s;
  s.name = "fingerprint";
  s.gravity = {0, -9.8F};
  s.warm_starting = true;
  s.continuous = true;
  Rng rng(0x70616472);
  for (int i = 0; i < 24; ++i) {
    BodyDef b;
    b.shape = i % 2 == 0 ? ShapeKind::kBox : ShapeKind::kCircle;
    b.radius = 0.3F;
    b.half = {0.2F + 0.02F * static_cast<float>(i % 5), 0.3F};
    b.mass = 1.0F + static_cast<float>(i % 7);
    b.position = {1.0F + static_cast<float>(i % 6), 1.0F + std::floor(static_cast<float>(i) / 6.0F)};
    b.angle = static_cast<float>(rng.uniform(-3, 3));
    b.velocity = {static_cast<float>(rng.uniform(-4, 4)), static_cast<float>(rng.uniform(-4, 4))};
    s.bodies.push_back(b);
  }
  const auto wall = [&s](Vec2 position, Vec2 half, float angle) {
    BodyDef b;
    b.shape = ShapeKind::kBox;
    b.half = half;
    b.position = position;
    b.angle = angle;
    s.statics.push_back(b);
  };
  wall({3.5F, -1}, {6, 1}, 0.05F);
  wall({-1, 4}, {1, 8}, 0);
  wall({8, 4}, {1, 8}, 0);
  return s;
}

}  // namespace

std::uint64_t physics_fingerprint() {
  World world(canned_scene(), 0);
  WideHasher h;
  Snapshot snapshot;
  for (int t = 0; t < 240; ++t) {
    world.step();
    if (t % 20 != 19) continue;
    world.save(snapshot);
    add_to_hash(h, snapshot);
  }
  return h.value();
}

}  // namespace padr::world
