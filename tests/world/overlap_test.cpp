#include "common/world/overlap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/rng.h"
#include "tests/seed.h"

namespace padr::world {
namespace {

constexpr Outline kBall{ShapeKind::kCircle, 0.5F, {}};
constexpr Outline kCrate{ShapeKind::kBox, 0, {1, 0.5F}};
constexpr float kQuarterTurn = 1.5707963F;
constexpr float kTolerance = 1e-5F;  // m

struct Pair {
  const char* what;
  Outline a;
  Pose at_a;
  Outline b;
  Pose at_b;
  float depth;
  Vec2 away;  ///< of no account where the depth is 0
};

TEST(Overlap, IsWhatTheShapesSay) {
  const float diagonal = std::sqrt(0.5F);
  for (const Pair& c : {
           Pair{"balls apart", kBall, {{0, 0}}, kBall, {{1.1F, 0}}, 0, {}},
           Pair{"balls overlap", kBall, {{0, 0}}, kBall, {{0.8F, 0}}, 0.2F, {-1, 0}},
           Pair{"ball at a crate's long side", kBall, {{0, 0.9F}}, kCrate, {{0, 0}}, 0.1F, {0, 1}},
           Pair{"the same crate upright", kBall, {{0, 0.9F}}, kCrate, {{0, 0}, kQuarterTurn}, 0.6F, {0, 1}},
           Pair{"ball off the corner", kBall, {{1.4F, 0.9F}}, kCrate, {{0, 0}}, 0, {}},
           Pair{"ball at the corner",
                kBall,
                {{1.3F, 0.8F}},
                kCrate,
                {{0, 0}},
                0.5F - std::sqrt(0.18F),
                {diagonal, diagonal}},
           Pair{"ball's centre in the crate", kBall, {{0.2F, 0.4F}}, kCrate, {{0, 0}}, 0.6F, {0, 1}},
           Pair{"crate and ball, the other way round", kCrate, {{0, 0}}, kBall, {{0, 0.9F}}, 0.1F, {0, -1}},
           Pair{"crates apart", kCrate, {{0, 0}}, kCrate, {{2.1F, 0}}, 0, {}},
           Pair{"crates overlap", kCrate, {{0, 0}}, kCrate, {{1.9F, 0.1F}}, 0.1F, {-1, 0}},
           Pair{"upright against lying", kCrate, {{0, 0}}, kCrate, {{1.4F, 0}, kQuarterTurn}, 0.1F, {-1, 0}},
       }) {
    const Overlap o = overlap(c.a, c.at_a, c.b, c.at_b);
    EXPECT_NEAR(o.depth, c.depth, kTolerance) << c.what;
    if (c.depth == 0) continue;
    EXPECT_NEAR(o.away.x, c.away.x, kTolerance) << c.what;
    EXPECT_NEAR(o.away.y, c.away.y, kTolerance) << c.what;
  }
}

TEST(Overlap, AfterMovingAwayByItsDepthTheyJustTouch) {
  Rng rng(test::seed(5));
  int found = 0;
  for (int i = 0; i < 5000; ++i) {
    const auto shape = [&rng] {
      const float size = static_cast<float>(rng.uniform(0.1, 1));
      return rng.uniform(0, 1) < 0.5 ? Outline{ShapeKind::kCircle, size, {}}
                                     : Outline{ShapeKind::kBox, 0, {size, static_cast<float>(rng.uniform(0.1, 1))}};
    };
    const auto pose = [&rng] {
      return Pose{{static_cast<float>(rng.uniform(-1, 1)), static_cast<float>(rng.uniform(-1, 1))},
                  static_cast<float>(rng.uniform(-4, 4))};
    };
    const Outline a = shape();
    const Outline b = shape();
    Pose at = pose();
    const Pose there = pose();
    const Overlap o = overlap(a, at, b, there);
    if (o.depth <= 0.001F) continue;
    ++found;
    at.position = at.position + o.away * (o.depth + kTolerance);
    ASSERT_LE(overlap(a, at, b, there).depth, kTolerance) << i;
    at.position = at.position - o.away * 0.001F;
    ASSERT_GT(overlap(a, at, b, there).depth, 0) << i << ": not farther than it needs";
  }
  EXPECT_GT(found, 1000);
}

TEST(Overlap, AStraightWayCrossesAShapeOrNot) {
  const Pose upright{{3, 0}, kQuarterTurn};  // from 2.5 to 3.5 m across, from -1 to 1 m high
  EXPECT_TRUE(crosses({0, 0}, {6, 0}, kCrate, upright));
  EXPECT_TRUE(crosses({0, 0.9F}, {6, 0.9F}, kCrate, upright));
  EXPECT_FALSE(crosses({0, 1.1F}, {6, 1.1F}, kCrate, upright)) << "above it";
  EXPECT_FALSE(crosses({0, 0}, {2.4F, 0}, kCrate, upright)) << "ends before it";
  EXPECT_FALSE(crosses({0, 0}, {3, 2}, kCrate, upright)) << "past its corner";
  EXPECT_TRUE(crosses({3, 5}, {3, -5}, kCrate, upright)) << "along its axis";
  EXPECT_FALSE(crosses({3.6F, 5}, {3.6F, -5}, kCrate, upright)) << "beside it";
  EXPECT_TRUE(crosses({0, 0.4F}, {6, 0.4F}, kBall, {{3, 0}}));
  EXPECT_FALSE(crosses({0, 0.6F}, {6, 0.6F}, kBall, {{3, 0}}));
}

}  // namespace
}  // namespace padr::world
