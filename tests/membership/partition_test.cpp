// The network falls into parts and comes together again.
#include "tests/membership/party.h"

namespace padr::test {
namespace {

constexpr wire::SealMode kModes[] = {wire::SealMode::kNone, wire::SealMode::kAuth};

lab::VirtualNetworkConfig sealed(int founders, const std::string& netem, std::uint64_t seed, wire::SealMode mode) {
  lab::VirtualNetworkConfig c = party_config(founders, netem, seed);
  c.seal = mode;
  return c;
}

TEST(Partition, TwoAndTwoForTenSecondsAreIdenticalWithinTwo) {
  Party party(4, "delay 50ms 10ms loss 1%", 31);
  party.run(6);
  party.net().attract(Vec2{10, 7.5F});  // both sides push the same bodies
  party.net().divide({{0, 0}, {1, 1}, {2, 0}, {3, 1}});
  party.run(10);
  for (int p = 0; p < 4; ++p) EXPECT_LT(party.lag(p), 120) << "both sides have gone on, and confirmed";
  EXPECT_FALSE(party.united());
  party.net().divide({});
  // Identical: one session, and the same confirmed world at a tick after the healing.
  const Tick healed = party.replica(0).now();
  const auto took = party.run_until(10, [&] {
    if (!party.united()) return false;
    for (int p = 0; p < 4; ++p)
      if (party.replica(p).agreed().confirmed().tick <= healed) return false;
    return true;
  });
  ASSERT_TRUE(took.has_value()) << party.story();
  std::printf("identical %.2f s after healing\n", *took);
  RecordProperty("identical_after_s", std::to_string(*took));
  EXPECT_LE(*took, 2.0) << party.story();
  const std::uint64_t before = party.judge().compared();
  party.run(5);
  EXPECT_EQ(party.judge().violation(), "");
  EXPECT_GT(party.judge().compared(), before + 6 * 200);
}

// Once, nobody looked for anybody any more after 20 minutes.
TEST(Partition, TwoSidesMeetAfterAnOutageOfHalfAnHour) {
  Party party(sealed(4, "delay 30ms", 34, wire::SealMode::kAuth));
  party.run(6);
  party.net().divide({{0, 1}, {1, 1}});
  party.run(30 * 60);
  party.net().divide({});
  const auto took = party.run_until(40, [&] { return party.united(); });
  ASSERT_TRUE(took) << party.story();
  std::printf("one session %.1f s after the outage\n", *took);
  party.run(4);
  EXPECT_EQ(party.judge().violation(), "");
}

TEST(Partition, TheLargerSideWins) {
  for (const auto mode : kModes) {
    Party party(sealed(5, "delay 30ms", 32, mode));
    party.run(6);
    party.net().divide({{0, 1}, {1, 1}});  // the founder is with the smaller side
    party.run(8);
    party.net().divide({});
    ASSERT_TRUE(party.run_until(6, [&] { return party.united(); }).has_value()) << party.story();
    std::vector<int> incarnations;
    for (int p = 0; p < 5; ++p) incarnations.push_back(party.net().peer(p).incarnation());
    EXPECT_EQ(incarnations, (std::vector<int>{1, 1, 0, 0, 0})) << party.story();
    party.run(4);
    EXPECT_EQ(party.judge().violation(), "");
  }
}

TEST(Partition, SidesThatHaveTakenInOthersMeetAgain) {
  for (const auto mode : kModes) {
    Party party(sealed(4, "delay 30ms 5ms loss 2%", 33, mode));
    party.run(6);
    party.net().divide({{2, 1}, {3, 1}, {5, 1}});
    party.run(5);
    party.net().start(0);
    party.net().start(3);
    party.run(5);
    party.net().divide({});
    ASSERT_TRUE(party.run_until(8, [&] { return party.united(); }).has_value()) << party.story();
    party.run(4);
    EXPECT_EQ(party.judge().violation(), "");
  }
}

// With a key only those count whom the other side knows, however many it has let in since.
TEST(Partition, WithAKeyNewcomersDoNotDecide) {
  Party party(sealed(5, "delay 30ms 5ms loss 2%", 36, wire::SealMode::kAuth));
  party.run(16);
  party.net().divide({{2, 1}, {3, 1}, {4, 1}});
  party.run(5);
  for (int i = 0; i < 4; ++i) party.net().start(0);
  party.run(5);
  EXPECT_EQ(party.net().peer(0).session().present(), 6) << party.story();
  party.net().divide({});
  ASSERT_TRUE(party.run_until(10, [&] { return party.united(); }).has_value()) << party.story();
  for (int p = 2; p < 5; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0) << party.story();
  for (const int p : {0, 1, 5, 6, 7, 8}) EXPECT_GT(party.net().peer(p).incarnation(), 0) << party.story();
  party.run(4);
  EXPECT_EQ(party.judge().violation(), "");
}

TEST(Partition, EveryoneAloneComesTogether) {
  for (const auto mode : kModes) {
    Party party(sealed(5, "delay 40ms 10ms loss 2%", 34, mode));
    party.run(6);
    party.net().divide({{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}});
    party.run(8);
    party.net().divide({});
    ASSERT_TRUE(party.run_until(15, [&] { return party.united(); }).has_value()) << party.story();
    party.run(4);
    EXPECT_EQ(party.judge().violation(), "");
  }
}

TEST(Partition, AShortOneIsOnlyAGap) {
  Party party(4, "delay 30ms", 35);
  party.run(6);
  party.net().divide({{2, 1}, {3, 1}});
  party.run(2);
  party.net().divide({});
  party.run(3);
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 4; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0);
  EXPECT_EQ(party.judge().violation(), "");
}

}  // namespace
}  // namespace padr::test
