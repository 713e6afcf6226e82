#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "tests/fights/fight.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

struct Link {
  const char* name;
  const char* netem;
  Tick least_delay;  ///< ticks one way
  Tick most_delay;   ///< likewise, of nearly all datagrams, lost ones sent again
};
constexpr std::array<Link, 3> kLinks{
    {{"Clean", "", 0, 1}, {"Slow", "delay 100ms", 6, 7}, {"Lossy", "delay 80ms 30ms loss 10%", 3, 60}}};

class Fights : public ::testing::TestWithParam<std::tuple<std::size_t, std::size_t>> {
 protected:
  const Arena arena = arenas()[std::get<0>(GetParam())];
  const Link& link = kLinks[std::get<1>(GetParam())];
};

// How fast anything may get: an avatar at full speed v throws what comes at it as fast as it was thrown before, and
// each time restitution e gives back its part. The limit is v (1 + e) / (1 - e). Correcting overlaps adds nothing.
float speed_limit(const Scene& s) {
  float e = s.avatar.restitution;
  for (const BodyDef& b : s.bodies) e = std::max(e, b.restitution);
  return s.avatar.max_speed * (1 + e) / (1 - e);
}

TEST_P(Fights, EndInPeace) {
  const std::uint64_t first = seed(1);
  const bool lossy = link.most_delay > 10;
  for (std::uint64_t s = first; s < first + (lossy ? 4 : 1); ++s) {
    SCOPED_TRACE(arena.name + " over \"" + link.netem + "\", seed " + std::to_string(s));
    const Outcome o = fight(arena, link.netem, s);
    std::printf(
        "takeovers %d, flips %d, dispute %d ticks, fastest %.1f m/s, overlap %.2f m for %d ticks, push-out %.2f m, "
        "loser's jump %.3f m (%s)\n",
        static_cast<int>(o.hand_overs.takeovers), static_cast<int>(o.hand_overs.flips), o.longest_dispute,
        static_cast<double>(o.fastest_body), static_cast<double>(o.deepest), o.longest_overlap,
        static_cast<double>(o.farthest_push_out), static_cast<double>(o.largest_foreign_jump),
        o.largest_jump_where.c_str());
    // Agreement.
    EXPECT_GT(o.confirmed_ticks, static_cast<std::uint64_t>(arena.seconds * kTicksPerSecond));
    EXPECT_EQ(o.differing_worlds, 0U);
    EXPECT_EQ(o.differing_owners, 0U);
    EXPECT_TRUE(o.rests_alike);
    EXPECT_TRUE(o.fought) << "both avatars must have touched the bodies, or nothing was tested";
    // Two believe to be the owner only until the word of one has reached the other.
    EXPECT_LE(o.longest_dispute, link.most_delay);
    // No ping-pong: who has lost a body learns of it a way later and waits a round trip; then it may
    // take it. Two ticks are for rounding and for what the round trip is believed to be.
    EXPECT_GE(o.closest_takeovers, std::max<Tick>(2, 3 * link.least_delay - 2));
    // No explosion.
    EXPECT_TRUE(o.finite);
    EXPECT_LE(o.fastest_body, speed_limit(arena.scene));
    EXPECT_LE(o.deepest, 0.9F) << "never through";
    EXPECT_LE(o.longest_overlap, 30);
    EXPECT_LE(o.farthest_push_out, 0.3F);
    // The loser sees a smooth bend: three times what a single correction may change in a tick.
    EXPECT_LE(o.largest_foreign_jump, 0.075F) << o.largest_jump_where;
    EXPECT_LE(o.leaps, lossy ? 4 : 0) << "it takes a lost update to be 3 m off";
  }
}

std::string name_of(const ::testing::TestParamInfo<Fights::ParamType>& info) {
  return arenas()[std::get<0>(info.param)].name + kLinks[std::get<1>(info.param)].name;
}

INSTANTIATE_TEST_SUITE_P(All, Fights,
                         ::testing::Combine(::testing::Range<std::size_t>(0, 5), ::testing::Range<std::size_t>(0, 3)),
                         name_of);

}  // namespace
}  // namespace padr::test
