// Members whose own link does not work, in a session with a key: another member carries for them.
#include "tests/membership/cut.h"
#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

lab::VirtualNetworkConfig sealed_party(int founders, const std::string& netem, std::uint64_t seed) {
  lab::VirtualNetworkConfig c = party_config(founders, netem, seed);
  c.seal = wire::SealMode::kAuth;
  return c;
}

/// Through whom the person `at` reaches the person `of`.
PeerId carrier(const Party& party, int of, int at) {
  return party.net().peer(at).carrier(party.replica(of).self());
}

class Carried : public testing::TestWithParam<Cut> {};

/// How far the confirmed world of anybody trails at most within so many seconds, ticks.
Tick worst_lag(Party& party, int seconds) {
  Tick worst = 0;
  for (int i = 0; i < 10 * seconds; ++i) {
    party.run(0.1);
    for (int p = 0; p < party.net().persons(); ++p) worst = std::max(worst, party.lag(p));
  }
  return worst;
}

/// A carried way is longer by one link, and its marks come through two that lose.
constexpr Tick kCarriedCosts = 30;

// Confirmed worlds trail by no more than a carried way costs, from two seconds after the cut on.
TEST_P(Carried, PlayGoesOnAsBefore) {
  const Cut& c = GetParam();
  Party party(sealed_party(4, "delay 50ms 10ms loss 1%", test::seed(81)));
  party.run(6);
  const Tick before = worst_lag(party, 25);
  party.net().cut(c.a, c.b, c.there);
  party.net().cut(c.b, c.a, c.back);
  party.run(2);
  EXPECT_LT(worst_lag(party, 25), before + kCarriedCosts);
  // What works is used.
  EXPECT_EQ(carrier(party, c.b, c.a) != kNoPeer, c.there) << party.story();
  EXPECT_EQ(carrier(party, c.a, c.b) != kNoPeer, c.back) << party.story();
  party.net().cut(c.a, c.b, false);
  party.net().cut(c.b, c.a, false);
  party.run(12);
  EXPECT_EQ(carrier(party, c.b, c.a), kNoPeer) << party.story();
  EXPECT_EQ(carrier(party, c.a, c.b), kNoPeer) << party.story();
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 4; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

INSTANTIATE_TEST_SUITE_P(Each, Carried, testing::ValuesIn(kCuts), [](const auto& cut) { return cut.param.name; });

// Without a carrier one of the two would be declared gone after five minutes.
TEST(CarriedForLong, IsForEver) {
  lab::VirtualNetworkConfig c = sealed_party(3, "delay 30ms", test::seed(83));
  Party party(c);
  party.run(6);
  const Tick before = worst_lag(party, 20);
  party.net().cut(0, 2, true);
  party.net().cut(2, 0, true);
  party.run(2);
  EXPECT_LT(worst_lag(party, 400), before + kCarriedCosts);
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 3; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0) << party.story();
  EXPECT_EQ(party.judge().violation(), "") << party.story();
}

TEST(CarriedBy, AnotherOneWhenTheCarrierVanishes) {
  Party party(sealed_party(5, "delay 30ms 5ms", test::seed(84)));
  party.run(6);
  party.net().cut(1, 2, true);
  party.net().cut(2, 1, true);
  party.run(5);
  const PeerId first = carrier(party, 2, 1);
  ASSERT_NE(first, kNoPeer);
  ASSERT_NE(carrier(party, 1, 2), kNoPeer);
  for (int p = 0; p < 5; ++p)
    if (party.replica(p).self() == first) party.net().kill(p);
  const auto took = party.run_until(5, [&] {
    const PeerId there = carrier(party, 2, 1);
    const PeerId back = carrier(party, 1, 2);
    return there != first && there != kNoPeer && back != first && back != kNoPeer;
  });
  ASSERT_TRUE(took) << party.story();
  EXPECT_LT(*took, 1.5);
  party.run(15);
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 5; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

// A carrier that takes everything and passes on nothing: the two try the other one, which takes longer.
TEST(CarriedBy, AnotherOneWhenTheCarrierPassesNothingOn) {
  int dropped = 0;
  Party party(sealed_party(4, "delay 20ms", test::seed(88)), [&](lab::VirtualNetwork& n) {
    n.on_start = [&](int person, node::ParticipantConfig& c) {
      if (person != 0) return;
      c.channels->may_carry = [&](const Endpoint&, const Endpoint&, std::size_t) {
        ++dropped;
        return false;
      };
    };
  });
  party.run(6);
  const PeerId slow = party.replica(3).self();
  for (const auto& [a, b] : {std::pair(3, 2), std::pair(2, 3)})
    party.net().shape(a, b, shell::parse_netem("delay 100ms"));
  party.net().cut(1, 2, true);
  party.net().cut(2, 1, true);
  party.run(10);
  EXPECT_GT(dropped, 10);
  int by_slow = 0;
  for (int i = 0; i < 700; ++i) {
    party.run(0.1);
    by_slow += carrier(party, 2, 1) == slow && carrier(party, 1, 2) == slow ? 1 : 0;
  }
  EXPECT_GT(by_slow, 525) << "the quicker one is tried again, ever more rarely\n" << party.story();
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 4; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

// The second member cannot reach the newcomer from the start.
TEST(CarriedBy, WhoLetsSomebodyIn) {
  Party party(sealed_party(2, "delay 30ms", test::seed(85)));
  party.run(5);
  party.net().cut(1, 2, true);
  party.net().cut(2, 1, true);
  ASSERT_EQ(party.net().start(0), 2);
  const auto took = party.run_until(5, [&] { return party.united() && carrier(party, 1, 2) == 0; });
  ASSERT_TRUE(took) << party.story();
  EXPECT_LT(*took, 3);
  party.expect_to_stay(3);
}

// While it was out, its slot was promised to a newcomer that has not come. It has another one now, and its former one
// is empty. Once, nobody carried for it any more.
TEST(CarriedBy, WhoHasComeBackInAnotherSlot) {
  Party party(sealed_party(4, "delay 30ms", test::seed(89)));
  party.run(6);
  const PeerId before = party.replica(3).self();
  party.net().divide({{3, 1}});
  party.run(6);
  const int newcomer = party.net().start(0);
  party.run(0.08);
  party.net().kill(newcomer);
  party.net().divide({});
  ASSERT_TRUE(party.run_until(10, [&] { return party.net().peer(3).incarnation() == 1 && party.united(); }));
  ASSERT_GT(party.replica(3).self(), before);
  party.net().cut(1, 3, true);
  party.net().cut(3, 1, true);
  party.run(10);
  for (const int p : {1, 3}) EXPECT_TRUE(party.noted(p, "is reached through peer")) << party.story();
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

// Of two, the one by which it takes less.
TEST(CarriedBy, TheQuickerOfTwo) {
  Party party(sealed_party(4, "delay 20ms", test::seed(86)));
  party.run(6);
  for (const auto& [a, b] : {std::pair(3, 2), std::pair(2, 3)})
    party.net().shape(a, b, shell::parse_netem("delay 150ms"));
  party.net().cut(1, 2, true);
  party.net().cut(2, 1, true);
  party.run(10);
  EXPECT_EQ(carrier(party, 2, 1), 0) << party.story();
  EXPECT_EQ(carrier(party, 1, 2), 0) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

// Each of its links works in one direction only: two members hear it, and it hears the third one. Once, it evicted the
// two, and then the third one confirmed another world.
TEST(CarriedBy, WhoHearsOneMemberAndIsHeardByOthers) {
  Party party(sealed_party(4, "delay 30ms", test::seed(88)));
  party.run(6);
  for (const auto& [a, b] : {std::pair(1, 0), std::pair(2, 0), std::pair(0, 3)}) party.net().cut(a, b, true);
  party.run(10);
  party.expect_to_stay(4);
}

// Nobody hears everybody, but everybody somebody who hears the other.
TEST(CarriedBy, AllInARing) {
  Party party(sealed_party(4, "delay 30ms", test::seed(87)));
  party.run(6);
  for (const auto& [a, b] : {std::pair(0, 2), std::pair(2, 0), std::pair(1, 3), std::pair(3, 1)})
    party.net().cut(a, b, true);
  party.run(10);
  party.expect_to_stay(4);
}

}  // namespace
}  // namespace padr::test
