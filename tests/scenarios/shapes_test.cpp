#include "common/scenarios/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/model/rng.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using testing::first_seed;

BodyDef circle(float x, float y, float radius) {
  BodyDef b;
  b.position = {x, y};
  b.radius = radius;
  return b;
}

BodyDef box(float x, float y, float half_x, float half_y, float angle = 0) {
  BodyDef b;
  b.shape = ShapeKind::kBox;
  b.position = {x, y};
  b.half = {half_x, half_y};
  b.angle = angle;
  return b;
}

void expect_separation(const BodyDef& a, const BodyDef& b, double expected) {
  EXPECT_NEAR(separation(a, b), expected, 1e-6);
  EXPECT_NEAR(separation(b, a), expected, 1e-6);
}

constexpr float kQuarter = 0.78539816F;

TEST(Shapes, SeparationOfKnownPairs) {
  expect_separation(circle(0, 0, 1), circle(3, 4, 2), 2);
  expect_separation(circle(0, 0, 1), circle(1, 0, 1), -1);
  expect_separation(circle(3, 0, 1), box(0, 0, 1, 5), 1);
  expect_separation(circle(4, 6, 1), box(0, 0, 1, 2), 4);             // from the corner
  expect_separation(circle(0.5F, 0, 0.25F), box(0, 0, 1, 2), -0.75);  // centre inside
  expect_separation(box(0, 0, 1, 1), box(3, 0.5F, 1, 1), 1);
  expect_separation(box(0, 0, 1, 1), box(5, 6, 1, 1), 5);  // corner to corner
  expect_separation(box(0, 0, 1, 1), box(1.5F, 0, 1, 1), -0.5);
  expect_separation(box(0, 0, 1, 1), box(3, 0, 1, 1, kQuarter), 2 - std::sqrt(2.0));
  expect_separation(box(0, 0, 5, 0.1F), box(0, 0, 0.1F, 5), -5.1);  // a cross
}

/// Whether a point of `a`, out of a grid over it, lies in `b`.
bool some_point_inside(const BodyDef& a, const BodyDef& b) {
  constexpr int kSteps = 60;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      const float u = static_cast<float>(i) / kSteps;
      const float v = static_cast<float>(j) / kSteps;
      const bool round = a.shape == ShapeKind::kCircle;
      if (round && u * u + v * v > 1) continue;
      const float x = u * (round ? a.radius : a.half.x);
      const float y = v * (round ? a.radius : a.half.y);
      const float c = std::cos(a.angle);
      const float s = std::sin(a.angle);
      const Vec2 d = a.position + Vec2{c * x - s * y, s * x + c * y} - b.position;
      if (b.shape == ShapeKind::kCircle ? length(d) <= b.radius
                                        : std::abs(std::cos(b.angle) * d.x + std::sin(b.angle) * d.y) <= b.half.x &&
                                              std::abs(std::cos(b.angle) * d.y - std::sin(b.angle) * d.x) <= b.half.y) {
        return true;
      }
    }
  }
  return false;
}

BodyDef random_body(Rng& rng) {
  const auto draw = [&](double low, double high) { return static_cast<float>(rng.uniform(low, high)); };
  const float x = draw(-1, 1);
  const float y = draw(-1, 1);
  if (rng.chance(0.4)) return circle(x, y, draw(0.1, 0.6));
  const float half_x = draw(0.1, 0.6);
  const float half_y = draw(0.1, 0.6);
  return box(x, y, half_x, half_y, draw(-6, 6));
}

TEST(Shapes, SeparationAgreesWithPointsTried) {
  const std::uint64_t first = first_seed();
  for (std::uint64_t seed = first; seed < first + 500; ++seed) {
    Rng rng(seed);
    const BodyDef a = random_body(rng);
    const BodyDef b = random_body(rng);
    const double gap = separation(a, b);
    const bool overlap = some_point_inside(a, b) || some_point_inside(b, a);
    // What is as thin as the grid is fine can be missed.
    if (gap > 1e-4 || gap < -0.03) {
      EXPECT_EQ(overlap, gap < 0) << "seed " << seed << " gap " << gap;
    }
    EXPECT_NEAR(gap, separation(b, a), 1e-12) << "seed " << seed;
  }
}

TEST(Shapes, ExtentAndReachHoldTheBody) {
  EXPECT_EQ(extent(circle(1, 1, 0.5F)), (Vec2{0.5F, 0.5F}));
  EXPECT_EQ(extent(box(1, 1, 0.5F, 0.25F)), (Vec2{0.5F, 0.25F}));
  EXPECT_NEAR(extent(box(0, 0, 1, 1, kQuarter)).x, std::sqrt(2.0F), 1e-6F);
  EXPECT_NEAR(reach(box(0, 0, 3, 4)), 5, 1e-12);
  EXPECT_NEAR(area(box(0, 0, 1, 2)), 8, 1e-12);
}

}  // namespace
}  // namespace padr::scenarios
