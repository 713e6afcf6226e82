#include "tools/lab/alternatives/claims.h"

#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "common/world/avatar_control.h"

namespace padr::lab::alternatives {
namespace {

TEST(Claims, HigherSequenceWinsAndWrapsRound) {
  EXPECT_TRUE(beats({0, 2, false, false}, {1, 1, false, false}, 7));
  EXPECT_FALSE(beats({1, 1, false, false}, {0, 2, false, false}, 7));
  EXPECT_TRUE(beats({0, 0, false, false}, {1, 65535, false, false}, 7));
}

TEST(Claims, EqualOnesAreDecidedOneWayForAll) {
  int lower = 0;
  for (EntityId body = 0; body < 200; ++body) {
    const Claim a{0, 1, false, false};
    const Claim b{1, 1, false, false};
    EXPECT_NE(beats(a, b, body), beats(b, a, body));
    EXPECT_FALSE(beats(a, a, body));
    lower += beats(a, b, body) ? 1 : 0;
  }
  EXPECT_GT(lower, 60);  // favours nobody
  EXPECT_LT(lower, 140);
}

/// An avatar pushed against the ball takes it, unless its owner holds it.
TEST(Claims, TakenByContactUnlessHeld) {
  const Scene scene = scenarios::load_embedded("ball", 1);
  for (const bool held : {false, true}) {
    world::World world(scene, 2);
    for (PeerId p = 0; p < 2; ++p) {
      world.set_present(world.avatar(p), true);
      world.set_free(p, true);
    }
    ClaimTable claims(1, world.bodies());
    ASSERT_TRUE(claims.hear(0, {0, 4, held, true}));
    EXPECT_FALSE(claims.mine(0));
    for (int tick = 0; tick < 600 && !claims.mine(0); ++tick) {
      world::drive_avatar(world, 1, world.position(0));
      world.step();
      claims.touch(world, world.avatar(1));
    }
    EXPECT_EQ(claims.mine(0), !held);
    EXPECT_EQ(claims.of(0).sequence, held ? 4 : 5);
    EXPECT_EQ(claims.hear(0, {0, 4, false, true}), held) << "a superseded owner is not heard";
  }
}

}  // namespace
}  // namespace padr::lab::alternatives
