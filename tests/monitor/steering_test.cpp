#include "common/monitor/steering.h"

#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "common/world/avatar_control.h"

namespace padr {
namespace {

using monitor::Drive;
using Kind = Drive::Kind;

/// One avatar alone in a world, driven as a peer does it.
struct Driven {
  Driven() : world(scenarios::load_embedded("proxy", 1), 1) {
    world.set_present(world.avatar(0), true);
    world.set_free(0, true);
  }
  void step(Vec2 own) {
    now += kMicrosPerSecond / kTicksPerSecond;
    world::View seen(world.scene(), world.slots());
    world.save(seen.change());
    target = steering.target(own, seen, world.avatar(0), now);
    world::drive_avatar(world, 0, target);
    world.step();
  }
  Vec2 position() const { return world.position(world.avatar(0)); }
  float speed() const { return length(world.velocity(world.avatar(0))); }

  world::World world;
  monitor::Steering steering;
  Micros now = 0;
  Vec2 target;
};

TEST(Steering, WithoutOrdersTheOwnInputDrives) {
  Driven d;
  d.step({3, 4});
  EXPECT_EQ(d.target, (Vec2{3, 4}));
  EXPECT_FALSE(d.steering.driven());
}

TEST(Steering, APointIsDrivenToAndKeptWithinTheScene) {
  Driven d;
  d.steering.take({Kind::kPoint, {2, 3}}, d.now);
  d.step({});
  EXPECT_EQ(d.target, (Vec2{2, 3}));
  EXPECT_TRUE(d.steering.driven());
  d.steering.take({Kind::kPoint, {1.0e6F, -1.0e6F}}, d.now);
  d.step({});
  EXPECT_EQ(d.target, (Vec2{d.world.scene().upper.x, d.world.scene().lower.y}));
}

TEST(Steering, ADirectionIsFullSpeedTowardsAPointThatStays) {
  Driven d;
  const Vec2 from = d.position();
  const float away = from.x > 5 ? -1.0F : 1.0F;
  d.steering.take({Kind::kDirection, {away, 0}}, d.now);
  d.step({});
  const Vec2 first = d.target;
  EXPECT_GT(distance(first, from), 25);
  for (int i = 0; i < 30; ++i) {
    d.steering.take({Kind::kDirection, {away, 0}}, d.now);
    d.step({});
    EXPECT_EQ(d.target, first) << "others need not be told of a target that stays";
  }
  EXPECT_GT(distance(d.position(), from), 1);
  EXPECT_LT(std::abs(d.position().y - from.y), 0.01F);
}

TEST(Steering, HalfADirectionIsHalfTheSpeed) {
  Driven d;
  const float away = d.position().x > 5 ? -0.5F : 0.5F;
  for (int i = 0; i < 40; ++i) {
    d.steering.take({Kind::kDirection, {away, 0}}, d.now);
    d.step({});
  }
  EXPECT_NEAR(d.speed(), d.world.scene().avatar.max_speed / 2, 0.3F);
}

TEST(Steering, NoDirectionBrakesAndStands) {
  Driven d;
  const float away = d.position().x > 5 ? -1.0F : 1.0F;
  for (int i = 0; i < 20; ++i) {
    d.steering.take({Kind::kDirection, {away, 0}}, d.now);
    d.step({});
  }
  EXPECT_GT(d.speed(), 1);
  for (int i = 0; i < 90; ++i) {
    d.steering.take({Kind::kDirection, {0, 0}}, d.now);
    d.step({});
  }
  const Vec2 stood = d.target;
  EXPECT_LT(d.speed(), 0.02F);
  d.steering.take({Kind::kDirection, {0, 0}}, d.now);
  d.step({});
  EXPECT_EQ(d.target, stood);
}

TEST(Steering, OrdersLapseUnlessTheyAreRepeated) {
  Driven d;
  d.steering.take({Kind::kPoint, {2, 3}}, d.now);
  const Micros lapses = d.now + monitor::kDriveLease;
  while (d.now + kMicrosPerSecond / kTicksPerSecond < lapses) {
    d.step({});
    EXPECT_TRUE(d.steering.driven());
  }
  d.step({});
  EXPECT_FALSE(d.steering.driven());
}

TEST(Steering, OnReleaseTheOwnInputGoesOnOnceItMoves) {
  Driven d;
  const Vec2 own{1, 1};
  d.steering.take({Kind::kPoint, {2, 3}}, d.now);
  for (int i = 0; i < 60; ++i) d.step(own);
  d.steering.take({Kind::kRelease, {}}, d.now);
  d.step(own);
  const Vec2 left = d.target;
  EXPECT_LT(distance(left, d.position()), 0.1F);
  d.step(own);
  EXPECT_EQ(d.target, left) << "who stands still stays where it was left";
  d.step({1.01F, 1});
  EXPECT_EQ(d.target, (Vec2{1.01F, 1}));
  d.step(own);
  EXPECT_EQ(d.target, own);
}

}  // namespace
}  // namespace padr
