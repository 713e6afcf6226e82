// Scenarios with another number of bodies.
#include "common/scenarios/bodies.h"

#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "tests/lab_sweep/error_of.h"

namespace padr::scenarios {
namespace {

using test::error_of;

Scene with(const char* name, std::uint32_t bodies) {
  return load(with_bodies(embedded_text(name), name, bodies), name, 7);
}

TEST(WithBodies, TheSameNumberIsTheSameScene) {
  EXPECT_EQ(scene_hash(with("arena", 60)), scene_hash(load_embedded("arena", 7)));
  EXPECT_EQ(scene_hash(with("dominoes", 20)), scene_hash(load_embedded("dominoes", 7)));
}

TEST(WithBodies, CountsThemAll) {
  for (const std::uint32_t n : {1U, 20U, 100U}) EXPECT_EQ(with("arena", n).bodies.size(), n);
  for (const std::uint32_t n : {1U, 7U}) EXPECT_EQ(with("dominoes", n).bodies.size(), n);
}

TEST(WithBodies, RefusesWhatHasNoBlockToChange) {
  EXPECT_EQ(error_of([] { with_bodies(embedded_text("van"), "van", 10); }),
            "van:1:1: has neither a scatter nor a row block whose count could be changed");
}

TEST(WithBodies, KeepsTheBodiesThatAreListed) {
  std::string text(embedded_text("dominoes"));
  text += "body { radius: 0.3 mass: 1 position { x: 1 y: 5 } }\n";
  EXPECT_EQ(load(with_bodies(text, "two", 2), "two", 1).bodies.size(), 2U);
  EXPECT_NE(
      error_of([&] { with_bodies(text, "two", 1); }).find("allowed: more than the 1 that are not of its last row"),
      std::string::npos);
}

}  // namespace
}  // namespace padr::scenarios
