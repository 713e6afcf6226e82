#include "common/shown/tracking.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/shown/clearance.h"
#include "tests/world/test_scene.h"

namespace padr::sync {
namespace {

/// Ticks until an offset is made up for, from rest to rest.
int ticks_to_glide(float offset) {
  Vec2 at{offset, 0};
  Vec2 stride;
  for (int t = 1;; ++t) {
    stride = believable_stride(fastest_glide(at), stride, {});
    at = at + stride;
    if (length(at) < 1e-5F) return t;
    if (t > 1000) return -1;
  }
}

// In n ticks, with steps that rise by a and fall by a to nothing: 1, 1 + 1, 1 + 2 + 1, 1 + 2 + 2 + 1, ... times a.
int fewest_ticks(float offset) {
  int n = 1;
  while (kMostChange * std::floor(static_cast<float>((n + 1) * (n + 1)) / 4) < offset) ++n;
  return n;
}

TEST(Tracking, TakesTheLeastTimeOrATickMore) {
  int as_few = 0;
  int all = 0;
  for (float offset = 0.001F; offset < 3; offset *= 1.05F, ++all) {
    const int ticks = ticks_to_glide(offset);
    EXPECT_GE(ticks, fewest_ticks(offset)) << offset;
    EXPECT_LE(ticks, fewest_ticks(offset) + 1) << offset;
    if (ticks == fewest_ticks(offset)) ++as_few;
  }
  EXPECT_GT(as_few, all / 3);
}

TEST(Tracking, AStepIsBelievableNearTheLastOneTheExplainedOneAndAnyBetween) {
  const Vec2 last{0.1F, 0};
  const Vec2 straight{-0.1F, 0};
  EXPECT_EQ(believable_stride({0.05F, 0}, last, straight), (Vec2{0.05F, 0})) << "a bounce";
  EXPECT_EQ(believable_stride({0.12F, 0}, last, straight), (Vec2{0.12F, 0}));
  EXPECT_NEAR(believable_stride({0.5F, 0}, last, straight).x, 0.1F + kMostChange, 1e-6F);
  EXPECT_NEAR(believable_stride({0, -1}, last, straight).y, -kMostChange, 1e-6F);
}

/// Two balls of 0.3 m and a wall between x = 5 and x = 6, from y = -1 to y = 1.
Scene two_balls_and_a_wall() {
  return test::balls_and_a_wall(2, {0.5F, 1}, {5.5F, 0});
}

struct Room {
  /// Ball 0 is led; both are there in the live world.
  Room(Vec2 first, Vec2 second) {
    view.change().entities[0].position = first;
    view.change().entities[1].position = second;
  }
  /// Where ball 0 is shown that would have been shown at `now`; the other one is shown where it is.
  Vec2 keep(Vec2 before, Vec2 now) {
    const Vec2 other = view.position(1);
    std::vector<Vec2> shown{now, other};
    moved = clearance.keep(view, {0}, {before, other}, shown);
    EXPECT_EQ(shown[1], other);
    return shown[0];
  }
  Scene scene = two_balls_and_a_wall();
  Clearance clearance{scene, 0};
  world::View view{scene, 0};
  std::vector<EntityId> moved;
};

TEST(Clearance, WhatIsLedStopsAtOtherThings) {
  Room room({0, 0}, {1, 0});
  EXPECT_NEAR(room.keep({0.3F, 0}, {0.6F, 0}).x, 0.4F, 1e-5F);
  EXPECT_EQ(room.moved, std::vector<EntityId>{0});
  EXPECT_EQ(room.keep({0.2F, 0}, {0.35F, 0}), (Vec2{0.35F, 0})) << "nothing in its way";
  EXPECT_TRUE(room.moved.empty());
  EXPECT_NEAR(room.keep({4.6F, 0}, {4.9F, 0}).x, 4.7F, 1e-5F) << "the wall";
}

TEST(Clearance, AnOverlapThatWasThereMayShrinkButNotGrow) {
  Room room({0, 0}, {1, 0});
  EXPECT_EQ(room.keep({0.6F, 0}, {0.5F, 0}), (Vec2{0.5F, 0}));
  EXPECT_NEAR(room.keep({0.6F, 0}, {0.7F, 0}).x, 0.6F, 1e-5F);
  Room overlapping({0.6F, 0}, {1, 0});
  EXPECT_EQ(overlapping.keep({0.3F, 0}, {0.6F, 0}), (Vec2{0.6F, 0})) << "as in the live world";
}

TEST(Clearance, WhatHasToPassIsLetThrough) {
  Room room({2, 0}, {1, 0});
  EXPECT_EQ(room.keep({0.3F, 0}, {0.6F, 0}), (Vec2{0.6F, 0}));
}

TEST(Clearance, AnAbsentThingIsInNobodysWay) {
  Room room({0, 0}, {1, 0});
  room.view.set_present(1, false);
  EXPECT_EQ(room.keep({0.3F, 0}, {0.6F, 0}), (Vec2{0.6F, 0}));
}

TEST(Clearance, TwoThatAreLedMakeRoomForEachOther) {
  Room room({0, 0}, {1, 0});
  std::vector<Vec2> shown{{0.3F, 0}, {0.7F, 0}};
  room.clearance.keep(room.view, {0, 1}, {{0, 0}, {1, 0}}, shown);
  EXPECT_NEAR(shown[0].x, 0.2F, 1e-5F);
  EXPECT_NEAR(shown[1].x, 0.8F, 1e-5F);
}

TEST(Clearance, AWallIsBetweenOrNot) {
  const Room room({0, 0}, {1, 0});
  EXPECT_TRUE(room.clearance.is_wall_between({4, 0}, {7, 0}));
  EXPECT_FALSE(room.clearance.is_wall_between({4, 2}, {7, 2}));
  EXPECT_FALSE(room.clearance.is_wall_between({1, 0}, {4, 0}));
}

}  // namespace
}  // namespace padr::sync
