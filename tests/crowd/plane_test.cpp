// The plane: which region is where, and what is in it at the beginning.
#include <gtest/gtest.h>

#include <set>

#include "common/crowd/regions.h"
#include "common/sync/residents.h"

namespace padr::crowd {
namespace {

TEST(Plane, EveryPointIsInOneRegion) {
  const Plane plane;
  EXPECT_EQ(region_at(plane, {0, 0}), (Region{0, 0}));
  EXPECT_EQ(region_at(plane, {23.99F, 24}), (Region{0, 1}));
  EXPECT_EQ(region_at(plane, {-0.01F, -24.01F}), (Region{-1, -2}));
}

// A float that is too large for an int becomes the least one on x86-64, and the largest one on aarch64.
TEST(Plane, WhatIsFarAwayIsInTheLastRegionOnEveryProcessor) {
  const Plane plane;
  EXPECT_EQ(region_at(plane, {3e38F, -3e38F}), (Region{kMostRegion, -kMostRegion}));
  EXPECT_EQ(region_at(plane, {-1e12F, 1e12F}), (Region{-kMostRegion, kMostRegion}));
}

TEST(Plane, DistancesFromABorder) {
  const Plane plane;
  EXPECT_FLOAT_EQ(outside(plane, {0, 0}, {5, 5}), 0);
  EXPECT_FLOAT_EQ(outside(plane, {0, 0}, {27, 28}), 5);  // off a corner: 3, 4
  EXPECT_FLOAT_EQ(inside(plane, {0, 0}, {5, 22}), 2);
  EXPECT_FLOAT_EQ(inside(plane, {0, 0}, {-1, 12}), -1);
}

TEST(Plane, AroundAreThoseNearerThanThat) {
  const Plane plane;
  EXPECT_EQ(around(plane, {12, 12}, 6), (std::vector<Region>{{0, 0}}));
  EXPECT_EQ(around(plane, {3, 12}, 6), (std::vector<Region>{{-1, 0}, {0, 0}}));
  EXPECT_EQ(around(plane, {3, 3}, 6).size(), 4U);
  // 5 m from two borders, and 7.07 m from the corner.
  EXPECT_EQ(around(plane, {5, 5}, 6), (std::vector<Region>{{-1, 0}, {0, -1}, {0, 0}}));
  EXPECT_EQ(around(plane, {6, 12}, 6).size(), 1U);  // at the reach itself: not nearer
}

TEST(Plane, NumbersAreNeverZeroAndNeighboursDiffer) {
  std::set<std::uint16_t> numbers;
  std::set<std::uint32_t> ids;
  for (int x = -40; x <= 40; ++x)
    for (int y = -40; y <= 40; ++y) {
      EXPECT_NE(number_of({x, y}), 0);
      EXPECT_NE(id_of({x, y}), 0U);
      numbers.insert(number_of({x, y}));
      ids.insert(id_of({x, y}));
    }
  EXPECT_EQ(numbers.size(), 81U * 81U);
  EXPECT_EQ(ids.size(), 81U * 81U);
  EXPECT_EQ(number_of({0, 0}), number_of({255, 0}));  // two regions may have one number, far apart
}

TEST(RegionScene, IsAFunctionOfTheRegionAndTheSeed) {
  Plane plane;
  const std::uint64_t here = scene_hash(scene_of(plane, {3, -2}));
  EXPECT_EQ(here, scene_hash(scene_of(plane, {3, -2})));
  EXPECT_NE(here, scene_hash(scene_of(plane, {-2, 3})));
  plane.seed = 2;
  EXPECT_NE(here, scene_hash(scene_of(plane, {3, -2})));
}

TEST(RegionScene, BodiesBeginInsideAndApartAndSpareSlotsAreEmpty) {
  const Plane plane;
  const Scene s = scene_of(plane, {-7, 9});
  ASSERT_TRUE(s.region);
  ASSERT_EQ(s.bodies.size(), static_cast<std::size_t>(plane.bodies + plane.spare));
  const sync::Residents r = sync::residents_of(s);
  for (std::size_t b = 0; b < s.bodies.size(); ++b) {
    const bool there = b < static_cast<std::size_t>(plane.bodies);
    EXPECT_EQ(r.slots[b].present, there) << b;
    if (!there) continue;
    EXPECT_GE(inside(plane, {-7, 9}, s.bodies[b].position), 1) << b;
    for (std::size_t c = 0; c < b; ++c) EXPECT_GT(distance(s.bodies[b].position, s.bodies[c].position), 1) << b << c;
  }
}

}  // namespace
}  // namespace padr::crowd
