// Each lie is found, and names the liar and nobody else: in the traces of all others, and in each alone.
#include <gtest/gtest.h>

#include <iostream>

#include "tests/lab_audit/lies.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

using lab::audit::Kind;
using lab::audit::Report;

constexpr const char* kLinks[] = {"delay 30ms 5ms loss 1%", "delay 100ms 50ms loss 10%"};

/// Seed and link.
class Liars : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  static std::uint64_t seed() {
    const auto s = static_cast<std::uint64_t>(std::get<0>(GetParam()));
    std::cout << "seed " << s << "\n";
    return s;
  }
  static std::string netem() { return kLinks[std::get<1>(GetParam())]; }
};

TEST_P(Liars, TeleportIsFound) {
  LiarTrial t(seed(), netem());
  teleport(t, 6);
  t.run(6);
  const Report r = t.report();
  EXPECT_GT(LiarTrial::count(r, Kind::kAvatarWay), 0) << t.trial().party().story();
  for (const auto& f : r.findings) EXPECT_TRUE(f.is_signed);
}

TEST_P(Liars, SpeedIsFound) {
  LiarTrial t(seed(), netem());
  speed_up(t, 2.5F);
  t.run(8);
  const Report r = t.report();
  EXPECT_GT(LiarTrial::count(r, Kind::kAvatarSpeed), 0);
}

TEST_P(Liars, ClaimAcrossTheMapIsFound) {
  LiarTrial t(seed(), netem());
  claim_far_body(t, farthest_body(t));
  t.run(6);
  const Report r = t.report();
  EXPECT_GT(LiarTrial::count(r, Kind::kClaim), 0) << lines(r);
}

TEST_P(Liars, EnergyFromNowhereIsFound) {
  LiarTrial t(seed(), netem());
  give_energy(t, 30);
  t.run(8);
  const Report r = t.report();
  EXPECT_GT(LiarTrial::count(r, Kind::kBodySpeed), 0) << lines(r);
}

// The traces of who is told one thing and who is told another prove it, by two signatures.
TEST_P(Liars, TwoStoriesAreProven) {
  LiarTrial t(seed(), netem());
  t.trial().party().net().attract(Vec2{10, 7});
  tell_one_otherwise(t, 0.01F);
  t.run(8);
  const Report r = t.report();
  ASSERT_GT(LiarTrial::count(r, Kind::kTwoUpdates), 0);
  for (const auto& f : r.findings) {
    if (f.kind != Kind::kTwoUpdates) continue;
    EXPECT_TRUE(f.is_signed);
    EXPECT_GE(f.traces.size(), 2U);
    EXPECT_NEAR(f.measured, 0.01F, 1e-4F);
  }
}

INSTANTIATE_TEST_SUITE_P(Each, Liars, testing::Combine(testing::Range(501, 505), testing::Range(0, 2)));

// A body is only known to have lain somewhere if nobody else was near.
TEST(LiarsWhoFetch, AreFoundWhereNobodyElseWas) {
  const std::uint64_t first = test::seed(501);
  int found = 0;
  for (std::uint64_t seed = first; seed < first + 8; ++seed) {
    LiarTrial t(seed, kLinks[seed % 2]);
    fetch_body(t, lonely_body(t, 7), 7);
    t.run(6);
    const Report r = t.report();
    if (LiarTrial::count(r, Kind::kBodyJump) + LiarTrial::count(r, Kind::kClaim) > 0) ++found;
  }
  EXPECT_GE(found, 4);
}

// In a session without a key nothing is proof, but it is seen.
TEST(LiarsWithoutAKey, TwoStoriesAreSeen) {
  LiarTrial t(511, kLinks[0], wire::SealMode::kNone);
  tell_one_otherwise(t, 0.5F);
  t.run(3);
  const Report r = t.report();
  ASSERT_GT(LiarTrial::count(r, Kind::kTwoUpdates), 0);
  for (const auto& f : r.findings) EXPECT_FALSE(f.is_signed);
}

// A liar tells one member alone that bodies lie in its way. That one believes it, and acts on it.
TEST_P(Liars, WhoIsMisledIsNotBlamed) {
  LiarTrial t(seed(), netem());
  t.trial().party().net().attract(Vec2{10, 7});
  const Tick from = t.from();
  t.trial().liar().begin([&t, from](sync::StatePacket& p, PeerId to) {
    if (to != 1) return;
    for (sync::Bundle& b : p.updates) {
      if (b.tick < from) continue;
      b.bodies.clear();
      for (EntityId body = 0; body < 12; ++body) {
        sync::BodyUpdate u = claim_of(t.trial().replica(1), body, b.tick);
        u.epoch = t.trial().replica(1).agreed().confirmed().authority[body].epoch + 100;
        u.state.position = {9.0F + 0.1F * static_cast<float>(body), 7};
        b.bodies.push_back(u);
      }
    }
  });
  t.run(8);
  const Report r = t.report();
  EXPECT_GT(LiarTrial::count(r, Kind::kTwoUpdates), 0);
}

}  // namespace
}  // namespace padr::test
