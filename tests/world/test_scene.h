#pragma once

#include "common/model/rng.h"
#include "common/model/scene.h"

namespace padr::test {

/// A walled box seen from above, filled with circles and tilted boxes that already move: contacts everywhere.
inline Scene busy_scene(std::uint64_t seed, int bodies, bool warm_starting = false, float gravity = 0) {
  Scene s;
  s.name = "busy";
  s.lower = {0, 0};
  s.upper = {10, 8};
  s.gravity = {0, gravity};
  s.warm_starting = warm_starting;
  s.avatar = {0.4F, 80, 0.2F, 0.1F, 40, 10, 1600, 6, false, {{1, 1}, {9, 1}, {1, 7}, {9, 7}}};
  Rng rng(seed);
  for (int i = 0; i < bodies; ++i) {
    BodyDef b;
    b.shape = rng.chance(0.5) ? ShapeKind::kCircle : ShapeKind::kBox;
    b.radius = static_cast<float>(rng.uniform(0.15, 0.3));
    b.half = {static_cast<float>(rng.uniform(0.15, 0.4)), static_cast<float>(rng.uniform(0.15, 0.4))};
    b.mass = static_cast<float>(rng.uniform(2, 40));
    b.linear_damping = 0.6F;
    b.angular_damping = 0.6F;
    b.position = {static_cast<float>(rng.uniform(1, 9)), static_cast<float>(rng.uniform(1, 7))};
    b.angle = static_cast<float>(rng.uniform(-3, 3));
    b.velocity = {static_cast<float>(rng.uniform(-5, 5)), static_cast<float>(rng.uniform(-5, 5))};
    s.bodies.push_back(b);
  }
  const auto wall = [&s](Vec2 position, Vec2 half) {
    BodyDef b;
    b.shape = ShapeKind::kBox;
    b.half = half;
    b.position = position;
    s.statics.push_back(b);
  };
  wall({5, -1}, {7, 1});
  wall({5, 9}, {7, 1});
  wall({-1, 4}, {1, 6});
  wall({11, 4}, {1, 6});
  return s;
}

/// The avatar at (2, 4), one body of 10 kg at (5, 4), walls far off, nothing else.
inline Scene corridor() {
  Scene s = busy_scene(1, 0);
  BodyDef b;
  b.radius = 0.5F;
  b.mass = 10;
  b.position = {5, 4};
  s.bodies.push_back(b);
  s.avatar.spawns = {{2, 4}};
  return s;
}

/// Balls of 0.3 m, all at (0, 0), and one wall.
inline Scene balls_and_a_wall(std::size_t balls, Vec2 half, Vec2 position) {
  Scene s;
  s.bodies.resize(balls);
  for (BodyDef& b : s.bodies) b.radius = 0.3F;
  s.statics.resize(1);
  s.statics[0].shape = ShapeKind::kBox;
  s.statics[0].half = half;
  s.statics[0].position = position;
  return s;
}

}  // namespace padr::test
