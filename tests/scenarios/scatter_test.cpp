#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/scenarios/scenarios.h"
#include "common/scenarios/shapes.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using testing::error_of;
using testing::first_seed;

std::string file(const std::string& blocks) {
  return "name: \"t\" title: \"t\" lower { x: -10 y: 0 } upper { x: 10 y: 10 } avatar { radius: 0.4 mass: 80 "
         "stiffness: 40 "
         "damping: 10 max_force: 1600 max_speed: 6 spawn { x: -9 y: 1 } } " +
         blocks;
}

const char* const kOnRight =
    "scatter { count: 20 lower { x: 2 y: 2 } upper { x: 9 y: 9 } margin: 0.5 gap: 0.2 kind { radius { min: 0.2 max: "
    "0.3 } "
    "mass { min: 1 max: 2 } } } ";
const char* const kOnLeft =
    "scatter { count: 20 lower { x: -9 y: 2 } upper { x: -2 y: 9 } kind { share: 3 box { half_width { min: 0.1 max: "
    "0.2 } "
    "half_height { min: 0.2 max: 0.3 } } density { min: 10 max: 20 } angle { min: 1 max: 2 } material { friction: 0.9 "
    "} } "
    "kind { radius { min: 0.3 max: 0.3 } mass { min: 7 max: 7 } } } ";

TEST(Scatter, EveryValueIsInItsRange) {
  const std::uint64_t first = first_seed();
  int boxes = 0;
  for (std::uint64_t seed = first; seed < first + 50; ++seed) {
    const Scene scene = load(file(std::string(kOnRight) + kOnLeft), "t", seed);
    ASSERT_EQ(scene.bodies.size(), 40U);
    for (std::size_t i = 0; i < 20; ++i) {
      const BodyDef& b = scene.bodies[i];
      EXPECT_TRUE(b.radius >= 0.2F && b.radius <= 0.3F && b.mass >= 1 && b.mass <= 2) << "seed " << seed;
      EXPECT_TRUE(b.position.x >= 2.5F + b.radius && b.position.x <= 8.5F - b.radius) << "seed " << seed;
      for (std::size_t j = 0; j < i; ++j) EXPECT_GE(separation(b, scene.bodies[j]), 0.2 - 1e-6) << "seed " << seed;
    }
    for (std::size_t i = 20; i < 40; ++i) {
      const BodyDef& b = scene.bodies[i];
      if (b.shape == ShapeKind::kCircle) {
        EXPECT_TRUE(b.radius == 0.3F && b.mass == 7 && b.friction == 0.3F) << "seed " << seed;
        continue;
      }
      ++boxes;
      EXPECT_TRUE(b.half.x >= 0.1F && b.half.x <= 0.2F && b.half.y >= 0.2F && b.half.y <= 0.3F) << "seed " << seed;
      EXPECT_TRUE(b.angle >= 1 && b.angle <= 2 && b.friction == 0.9F) << "seed " << seed;
      const double density = static_cast<double>(b.mass) / area(b);
      EXPECT_TRUE(density > 9.999 && density < 20.001) << "seed " << seed;
    }
  }
  // Shares 3 : 1 of 1,000 bodies, six standard deviations wide.
  EXPECT_GT(boxes, 668);
  EXPECT_LT(boxes, 832);
}

TEST(Scatter, AChangeToOneBlockLeavesTheChoicesOfTheOthersAlone) {
  const Scene both = load(file(std::string(kOnRight) + kOnLeft), "t", 5);
  std::string fewer(kOnRight);
  fewer.replace(fewer.find("20"), 2, "10");
  const Scene changed = load(file(fewer + kOnLeft), "t", 5);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(both.bodies[20 + i].position, changed.bodies[10 + i].position);
}

TEST(Scatter, KeepsClearOfSpawnsAndOfWhatIsThere) {
  const std::uint64_t first = first_seed();
  for (std::uint64_t seed = first; seed < first + 50; ++seed) {
    const Scene scene =
        load(file("obstacle { half { x: 3 y: 0.5 } position { x: 0 y: 5 } angle: 0.7 } body { radius: 1 mass: 1 "
                  "position { x: 6 y: 5 } } scatter { count: 60 gap: 0.1 spawn_clearance: 2 kind { radius { "
                  "min: 0.2 max: 0.4 } mass { min: 1 max: 2 } } }"),
             "t", seed);
    for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
      const BodyDef& b = scene.bodies[i];
      EXPECT_GE(separation(b, scene.statics[0]), 0.1 - 1e-6) << "seed " << seed;
      EXPECT_GE(separation(b, scene.bodies[0]), 0.1 - 1e-6) << "seed " << seed;
      EXPECT_GE(distance(b.position, scene.avatar.spawns[0]), 2 + 0.4F + b.radius - 1e-5F) << "seed " << seed;
    }
  }
}

TEST(Scatter, GivesUpInTimeEvenOnTheLargestBlockThatDoesNotFit) {
  const std::string blocks =
      "scatter { count: 5000 kind { box { half_width { min: 0.05 max: 0.2 } half_height { min: 0.05 max: 0.2 } } mass "
      "{ min: "
      "1 max: 2 } angle { min: 0 max: 3 } } }";
  const std::string message = error_of([&] { load(file(blocks), "t", 1); });
  EXPECT_NE(message.find("scatter[0] found room for "), std::string::npos) << message;
  EXPECT_NE(message.find(" of 5000 bodies, allowed: "), std::string::npos) << message;
}

}  // namespace
}  // namespace padr::scenarios
