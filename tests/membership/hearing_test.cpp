// Links that fail while their ends are well: who is heard by somebody is not declared gone.
#include "tests/membership/cut.h"
#include "tests/membership/party.h"
#include "tests/membership/uplink.h"
#include "tests/seed.h"
#include "tools/lab/testbed/harm.h"

namespace padr::test {
namespace {

class Hearing : public testing::TestWithParam<Cut> {};

// The two go on by what the others have of them. Persons sit in the slots of their numbers.
TEST_P(Hearing, WhoSomebodyHearsStays) {
  const Cut& c = GetParam();
  Party party(4, "delay 50ms 10ms loss 1%", 81);
  party.run(6);
  for (int p = 0; p < 4; ++p) ASSERT_EQ(party.replica(p).self(), p);
  party.net().cut(c.a, c.b, c.there);
  party.net().cut(c.b, c.a, c.back);
  Tick worst = 0;
  for (int s = 0; s < 25; ++s) {
    party.run(1);
    for (int p = 0; p < 4; ++p) worst = std::max(worst, party.lag(p));
  }
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 4; ++p) EXPECT_EQ(party.net().peer(p).incarnation(), 0) << party.story();
  EXPECT_LT(worst, 240) << "confirmed goes on, in steps";
  party.net().cut(c.a, c.b, false);
  party.net().cut(c.b, c.a, false);
  party.run(3);
  for (int p = 0; p < 4; ++p) EXPECT_LT(party.lag(p), 60) << p;
  EXPECT_EQ(party.judge().violation(), "");
}

INSTANTIATE_TEST_SUITE_P(Each, Hearing, testing::ValuesIn(kCuts), [](const auto& cut) { return cut.param.name; });

// Once, without a key, nothing was said of a link that others made up for.
TEST(HearingByRelay, IsTold) {
  Party party(4, "delay 50ms 10ms loss 1%", seed(82));
  party.run(20);
  for (int p = 0; p < 4; ++p) EXPECT_FALSE(party.noted(p, "is not reached")) << party.story();
  party.net().cut(0, 2, true);
  party.net().cut(2, 0, true);
  party.run(10);
  EXPECT_TRUE(party.noted(0, "peer 2 is not reached: the link to it does not work")) << party.story();
  EXPECT_TRUE(party.noted(2, "peer 0 is not reached")) << party.story();
  EXPECT_FALSE(party.noted(0, "directly again"));
  party.net().cut(0, 2, false);
  party.net().cut(2, 0, false);
  party.run(2);
  EXPECT_TRUE(party.noted(0, "peer 2 is reached directly again")) << party.story();
  EXPECT_TRUE(party.noted(2, "peer 0 is reached directly again")) << party.story();
  EXPECT_FALSE(party.noted(1, "reached"));
}

// What two that do not hear one another have told has to be kept until they say that they have it. So the others hold
// them together for five minutes, and then one of them is declared gone after all.
TEST(HearingForLong, IsNotForEver) {
  const std::uint64_t first = seed(83);
  for (std::uint64_t s = first; s < first + 4; ++s) {
    Party party(party_config(3, "delay 30ms", s, 4));
    party.run(6);
    party.net().cut(0, 2, true);
    party.net().cut(2, 0, true);
    party.run(295);
    EXPECT_TRUE(party.united()) << party.story();
    EXPECT_LT(party.lag(0), 240);
    EXPECT_LT(party.replica(2).kept().own_updates, 5U * 60U * 30U);
    party.run(25);
    EXPECT_FALSE(party.united());
    EXPECT_LT(party.lag(0), 240) << "and nobody waits for it\n" << party.story();
    EXPECT_EQ(party.judge().violation(), "") << "seed " << s << "\n" << party.story();
  }
}

// A peer confirms with its own updates before others have them. What nobody else has when it is declared gone is not
// the session's: it says where the difference begins, and goes on with the others' world.
TEST(Confirmed, OfAPeerThatIsDeclaredGoneIsTheSessionsOnlyAsFarAsSomebodyElseHasIt) {
  std::map<int, std::map<Tick, std::uint64_t>> confirmed;  // by person, of its first incarnation
  Party party(party_config(4, "delay 30ms", 84), [&](lab::VirtualNetwork& g) {
    g.on_confirmed = [&confirmed, judge = g.on_confirmed](int person, int incarnation, const sync::FoldState& s,
                                                          std::uint64_t hash) {
      if (incarnation == 0) confirmed[person][s.tick] = hash;
      judge(person, incarnation, s, hash);
    };
  });
  party.run(6);
  party.net().attract(Vec2{10, 7});
  party.run(0.5);
  const Tick together = party.replica(3).agreed().confirmed().tick;
  for (int p = 0; p < 3; ++p) party.net().cut(3, p, true);
  party.net().attract(Vec2{3, 3});
  party.run(2);
  const Tick alone = party.replica(3).agreed().confirmed().tick;
  EXPECT_GT(alone, party.replica(0).agreed().confirmed().tick) << "it hears the others, and they wait for it";
  party.run(4);
  for (int p = 0; p < 3; ++p) party.net().cut(3, p, false);
  ASSERT_TRUE(party.run_until(6, [&] { return party.united() && party.lag(3) < 60; }).has_value()) << party.story();
  EXPECT_EQ(party.net().peer(3).incarnation(), 1) << party.story();
  party.run(2);
  EXPECT_EQ(confirmed[3].at(together), confirmed[0].at(together));
  EXPECT_EQ(confirmed[1].at(alone), confirmed[0].at(alone));
  EXPECT_NE(confirmed[3].at(alone), confirmed[0].at(alone)) << "nobody else had what it said";
  EXPECT_EQ(party.judge().violation(), "");
}

// Four peers that mostly stand still, on a network that loses 3 % in bursts and nothing else.
TEST(HearingInBursts, NobodyIsDeclaredGone) {
  const std::uint64_t first = seed(1);
  for (std::uint64_t s = first; s < first + 3; ++s) {
    Party party(4, "delay 80ms 30ms distribution pareto loss gemodel 1% 30%", s);
    party.net().attract(Vec2{10, 7});
    party.run(120);
    for (int p = 0; p < 4; ++p)
      EXPECT_EQ(party.net().peer(p).incarnation(), 0) << "seed " << s << "\n" << party.story();
    EXPECT_EQ(party.judge().violation(), "") << "seed " << s;
  }
}

// How chaos counts who was declared gone without need.
TEST(HarmMeter, KnowsWhoWasEvictedAndWhetherOthersReachedIt) {
  Party party(4, "delay 20ms", test::seed(77));
  const std::set<int> nobody;
  lab::HarmMeter meter(party.net(), nobody);
  const auto run = [&](double s) {
    for (double t = 0; t < s; t += 0.1) {
      party.run(0.1);
      meter.look();
    }
  };
  run(15);
  party.net().cut(0, 3, true);
  party.net().cut(3, 0, true);
  run(15);  // others reach both
  EXPECT_EQ(meter.harm().evicted, 0);
  party.net().kill(1);  // does not count
  run(15);
  EXPECT_EQ(meter.harm().evicted, 0);
  party.net().divide({{3, 1}});
  run(8);
  EXPECT_GE(meter.harm().evicted, 1);
  party.net().divide({});
  run(15);
  EXPECT_EQ(meter.harm().evicted_reachable, 0);
}

int narrow_links(const Party& party) {
  int narrow = 0;
  for (int a = 0; a < party.net().persons(); ++a)
    for (PeerId b = 0; b < party.net().persons(); ++b)
      if (b != party.replica(a).self()) narrow += party.replica(a).link(b).out.rate().is_limited() ? 1 : 0;
  return narrow;
}

// What arrives at a peer that stands still waits for it. Once, its tick of before dated that, so that all other
// datagrams looked late, and each link to it was taken for one of 10 kbit/s, for minutes.
TEST(HearingHeldUp, WhoStandsStillNowAndThenHasNoNarrowLinks) {
  Party party(4, "delay 40ms 10ms loss 1%", seed(61));
  party.run(5);
  int narrow = 0;
  for (int i = 0; i < 30; ++i) {
    party.net().pause(1, true);
    party.run(0.15);
    party.net().pause(1, false);
    party.run(1.35);
    narrow += narrow_links(party);
  }
  EXPECT_EQ(narrow, 0);
}

TEST(HearingHeldUp, WhoStandsStillForSecondsHasNoNarrowLinks) {
  for (const char* const netem : {"delay 1ms", "delay 40ms 10ms loss 1%"})
    for (const double s : {0.2, 0.3, 0.4, 0.5, 0.75, 1.0, 1.5, 2.0, 2.8}) {
      Party party(3, netem, seed(62));
      party.run(6);
      party.net().pause(2, true);
      party.run(s);
      party.net().pause(2, false);
      int narrow = 0;
      for (int i = 0; i < 60; ++i) {
        party.run(0.1);
        narrow += narrow_links(party);
      }
      EXPECT_EQ(narrow, 0) << netem << ", " << s << " s";
    }
}

// Once, it sent a datagram for each tick that it had missed, and a narrow uplink took seconds for them.
TEST(HearingHeldUp, WhoCatchesUpSendsAFewDatagrams) {
  Party party(3, "delay 20ms", seed(63));
  party.run(8);
  const Tick then = party.replica(2).now();
  party.net().pause(2, true);
  party.run(2.5);
  party.net().pause(2, false);
  const std::uint64_t before = party.replica(2).stats().datagrams_sent;
  party.run_until(2, [&] { return party.replica(2).now() >= party.replica(0).now() - 2; });
  EXPECT_GT(party.replica(2).now() - then, 140) << "all ticks are made";
  EXPECT_LT(party.replica(2).stats().datagrams_sent - before, 2 * 50) << "on two links";
  party.run(1);
  EXPECT_LT(party.lag(0), 60);
  EXPECT_EQ(party.judge().violation(), "");
}

// Three links share an uplink that becomes narrow while all play. Once, most of what was sent found no room, each link
// was taken for one of ten times the rate, and after 8 s the others ignored this peer for a minute.
TEST(HearingThroughAFullUplink, NobodyIsIgnored) {
  for (const auto seal : {wire::SealMode::kNone, wire::SealMode::kEncrypt})
    for (const double room : {0.5, 2.0}) {
      SCOPED_TRACE("room for " + std::to_string(room) + " s");
      const auto uplink = std::make_shared<Uplink>();
      lab::VirtualNetworkConfig config = party_config(4, "delay 5ms 1ms", seed(5));
      config.seal = seal;
      config.technique = Technique{};
      Party party(config, [&](lab::VirtualNetwork& net) {
        net.on_start = [uplink](int person, node::ParticipantConfig& c) {
          if (person == 2) c.tamper = [uplink](node::Parcel p) { return (*uplink)(std::move(p)); };
        };
      });
      party.run(8);
      uplink->net = &party.net();
      uplink->kbit = 16;
      uplink->room_s = room;
      uplink->loss = 0.2;
      Tick worst = 0;
      for (int i = 0; i < 20; ++i) {
        party.run(1);
        worst = std::max(worst, party.lag(0));
      }
      std::printf("worst lag %d ticks, %d datagrams found no room\n", worst, uplink->full);
      EXPECT_TRUE(party.united()) << party.story();
      EXPECT_FALSE(party.noted(0, "ignored")) << party.story();
      EXPECT_EQ(party.net().peer(2).incarnation(), 0) << party.story();
      uplink->kbit = 0;
      party.run(5);
      EXPECT_LT(party.lag(0), 60);
      EXPECT_EQ(party.judge().violation(), "");
    }
}

}  // namespace
}  // namespace padr::test
