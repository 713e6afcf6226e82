#include "common/world/world.h"

#include <gtest/gtest.h>

#include "common/world/avatar_control.h"
#include "common/world/box2d_timer.h"
#include "tests/world/test_scene.h"

namespace padr::world {
namespace {

TEST(World, SameSceneSameBits) {
  const Scene scene = test::busy_scene(9, 60);
  World a(scene, 2);
  World b(scene, 2);
  Snapshot sa;
  Snapshot sb;
  for (int t = 0; t < 600; ++t) {
    a.step();
    b.step();
    a.save(sa);
    b.save(sb);
    ASSERT_EQ(sa.entities, sb.entities) << "tick " << t;
    ASSERT_EQ(sa.contacts, sb.contacts) << "tick " << t;
  }
}

TEST(World, ModelledAvatarPassesThroughWhatItDoesNotHold) {
  for (const bool held : {false, true}) {
    World w(test::corridor(), 1);
    w.set_present(w.avatar(0), true);
    w.set_hold(0, 0, held);
    for (int t = 0; t < 240; ++t) {
      drive_avatar(w, 0, {8, 4});
      w.step();
    }
    EXPECT_EQ(w.position(0).x > 5.5F, held);
    EXPECT_NEAR(w.position(w.avatar(0)).x, 8, 1.5);
  }
}

TEST(World, FreeAvatarCollidesWithEverything) {
  World w(test::corridor(), 1);
  w.set_present(w.avatar(0), true);
  w.set_free(0, true);
  bool touched = false;
  for (int t = 0; t < 120; ++t) {
    drive_avatar(w, 0, {8, 4});
    w.step();
    touched = touched || (!w.contacts().empty() && w.contacts()[0] == Contact{0, w.avatar(0)});
  }
  EXPECT_TRUE(touched);
  EXPECT_GT(w.position(0).x, 5.5F);
}

// Once, what fell out of a scene without a floor fell for ever, and nobody could join any more.
TEST(World, NothingGetsFarOutOfTheScene) {
  Scene scene = test::busy_scene(3, 12, false, -9.81F);
  scene.statics.clear();
  World w(scene, 1);
  w.set_present(w.avatar(0), true);
  w.set_state(0, {{4, 4}, 9.9e4F, {3, 3}, 90, true});
  Vec2 least, most;
  for (int t = 0; t < 60 * kTicksPerSecond; ++t) {
    drive_avatar(w, 0, {500, -500});
    w.step();
    for (EntityId e = 0; e < w.entities(); ++e) {
      least = {std::min(least.x, w.position(e).x), std::min(least.y, w.position(e).y)};
      most = {std::max(most.x, w.position(e).x), std::max(most.y, w.position(e).y)};
      ASSERT_LE(std::abs(w.state(e).angle), kMostAngle);
    }
  }
  EXPECT_EQ(least.y, scene.lower.y - kMostOutside);
  EXPECT_EQ(most.x, scene.upper.x + kMostOutside);
  EXPECT_GE(least.x, scene.lower.x - kMostOutside);
  EXPECT_EQ(w.velocity(w.avatar(0)).x, 0);
}

TEST(World, AbsentAvatarTouchesNothingAndStays) {
  World w(test::corridor(), 1);
  BodyState thrown = w.state(0);
  thrown.velocity = {-5, 0};
  w.set_state(0, thrown);
  for (int t = 0; t < 45; ++t) w.step();
  EXPECT_EQ(w.position(w.avatar(0)), (Vec2{2, 4}));
  EXPECT_LT(w.position(0).x, 2);
}

TEST(World, AvatarArrivesAndFallsAsleepExactlyAtRest) {
  World w(test::corridor(), 1);
  w.set_present(w.avatar(0), true);
  for (int t = 0; t < 600; ++t) {
    drive_avatar(w, 0, {3, 6});
    w.step();
  }
  const BodyState s = w.state(w.avatar(0));
  EXPECT_FALSE(s.awake);
  EXPECT_EQ(s.velocity, (Vec2{0, 0}));
  EXPECT_LT(distance(s.position, {3, 6}), 0.01F);
}

TEST(World, ControlForceKeepsItsLimits) {
  const AvatarDef def = test::corridor().avatar;
  EXPECT_LE(length(control_force(def, {0, 0}, {0, 0}, {100, 50})), def.max_force * 1.0001F);
  World w(test::corridor(), 1);
  w.set_present(w.avatar(0), true);
  float fastest = 0;
  for (int t = 0; t < 60; ++t) {
    drive_avatar(w, 0, {9, 7});
    w.step();
    fastest = std::max(fastest, length(w.velocity(w.avatar(0))));
  }
  EXPECT_LE(fastest, def.max_speed * 1.001F);
  EXPECT_GT(fastest, def.max_speed * 0.8F);
}

TEST(World, ContactsComeSortedAndOnce) {
  World w(test::busy_scene(4, 60), 0);
  std::size_t seen = 0;
  for (int t = 0; t < 200; ++t) {
    w.step();
    const auto& c = w.contacts();
    seen += c.size();
    for (std::size_t i = 1; i < c.size(); ++i) ASSERT_LT(c[i - 1], c[i]);
    for (const Contact& k : c) ASSERT_LT(k.first, k.second);
  }
  EXPECT_GT(seen, 100U);
}

TEST(World, NoClockInPhysics) {
  EXPECT_TRUE(box2d_timers_stand_still());
}

}  // namespace
}  // namespace padr::world
