#include "tests/fights/arenas.h"

#include <cmath>

#include "common/model/ids.h"

namespace padr::test {
namespace {

BodyDef circle(Vec2 position, float radius, float mass, float restitution) {
  BodyDef b;
  b.position = position;
  b.radius = radius;
  b.mass = mass;
  b.restitution = restitution;
  b.linear_damping = b.angular_damping = 0.5F;
  return b;
}

BodyDef wall(Vec2 position, Vec2 half) {
  BodyDef b;
  b.shape = ShapeKind::kBox;
  b.half = half;
  b.position = position;
  return b;
}

/// 20 m x 10 m between walls, seen from above; the two avatars start left and right of the middle, which is (10, 5).
Scene hall() {
  Scene s;
  s.name = "hall";
  s.lower = {0, 0};
  s.upper = {20, 10};
  s.avatar.radius = 0.4F;
  s.avatar.mass = 80;
  s.avatar.stiffness = 40;
  s.avatar.damping = 10;
  s.avatar.max_force = 1600;
  s.avatar.max_speed = 6;
  s.avatar.spawns = {{5, 5}, {15, 5}};
  s.statics = {wall({10, -1}, {12, 1}), wall({10, 11}, {12, 1}), wall({-1, 5}, {1, 7}), wall({21, 5}, {1, 7})};
  return s;
}

Script stand_until(double seconds, Vec2 where, Script then) {
  return [=](double t) { return t < seconds ? where : then(t - seconds); };
}

/// There for a while, then back to where it comes from.
Script visit(Vec2 where, double seconds, Vec2 home) {
  return [=](double t) { return t < seconds ? where : home; };
}

Arena clash(const std::string& name, double late) {
  Arena a{name, hall(), {}, 6};
  a.scene.bodies = {circle({10, 5}, 0.5F, 20, 0.2F)};
  a.scripts = {stand_until(0.5, {5, 5}, visit({10, 5}, 2, {4, 5})),
               stand_until(0.5 + late, {15, 5}, visit({10, 5}, 2, {16, 5}))};
  return a;
}

}  // namespace

Arena same_tick() {
  return clash("SameTick", 0);
}

Arena within_the_latency() {
  return clash("WithinTheLatency", 2.0 / kTicksPerSecond);
}

Arena pushed_from_both_sides() {
  Arena a{"PushedFromBothSides", hall(), {}, 12};
  a.scene.bodies = {circle({10, 5}, 0.5F, 20, 0.2F)};
  const auto push = [](float towards, double pace) {
    return [=](double t) { return Vec2{10 + towards, 5 + 0.25F * static_cast<float>(std::sin(t * pace))}; };
  };
  a.scripts = {stand_until(0.5, {5, 5}, push(2, 2.3)), stand_until(0.6, {15, 5}, push(-2, 3.1))};
  return a;
}

Arena two_stacks_meet() {
  Arena a{"TwoStacksMeet", hall(), {}, 8};
  for (int row = -1; row <= 1; ++row) {
    for (int column = 0; column < 4; ++column) {
      const auto out = 1.5F + 0.72F * static_cast<float>(column);
      const auto up = 5 + 0.72F * static_cast<float>(row);
      a.scene.bodies.push_back(circle({10 - out, up}, 0.35F, 10, 0.2F));
      a.scene.bodies.push_back(circle({10 + out, up}, 0.35F, 10, 0.2F));
    }
  }
  a.scripts = {stand_until(0.5, {5, 5}, visit({11, 5.1F}, 4, {3, 5})),
               stand_until(0.5, {15, 5}, visit({9, 4.9F}, 4, {17, 5}))};
  return a;
}

Arena volley() {
  Arena a{"Volley", hall(), {}, 20};
  a.scene.avatar.spawns = {{8.3F, 5}, {11.9F, 5}};
  a.scene.continuous = true;
  a.scene.bodies = {circle({10, 5}, 0.25F, 0.5F, 0.6F)};
  a.scene.statics.push_back(wall({10, 3.5F}, {6, 1}));
  a.scene.statics.push_back(wall({10, 6.5F}, {6, 1}));
  const auto swing = [](float home, float far, double pace) {
    return [=](double t) { return Vec2{home + far * static_cast<float>(std::sin(t * pace)), 5}; };
  };
  a.scripts = {stand_until(0.3, {8.3F, 5}, swing(8.3F, 1.7F, 4.1)),
               stand_until(0.3, {11.9F, 5}, swing(11.9F, 1.1F, 3.3))};
  return a;
}

std::vector<Arena> arenas() {
  return {same_tick(), within_the_latency(), pushed_from_both_sides(), two_stacks_meet(), volley()};
}

}  // namespace padr::test
