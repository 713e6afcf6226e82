// What becomes of those who wait for play when the founder ends or is started anew.
#include <gtest/gtest.h>

#include "tests/seed.h"
#include "tests/session/waiting.h"

namespace padr::test {
namespace {

// Those who came wait on, and whoever comes is let in by one of them.
TEST(SessionStart, TheFounderMayVanishBeforeIt) {
  Party party = waiting(3, 2);
  party.run(1);
  party.net().kill(0);
  party.run(1);
  party.net().start(1);
  party.net().start(1);
  ASSERT_TRUE(party.run_until(15, [&] { return party.started(); })) << party.story();
  party.run(3);
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

// Once, whoever had come to the founder before waited for ever in a session of its own.
TEST(SessionStart, AFounderThatIsStartedAnewIsJoinedByThoseWhoWait) {
  for (const auto seal : {wire::SealMode::kNone, wire::SealMode::kAuth})
    for (const bool says_goodbye : {false, true}) {
      lab::VirtualNetworkConfig config = party_config(4, "delay 40ms 10ms", seed(5));
      config.seal = seal;
      Party party(config, {}, 3);
      party.run(5);
      says_goodbye ? party.net().leave(0) : party.net().kill(0);
      ASSERT_TRUE(party.run_until(5, [&] { return !party.net().runs(0); }));
      const int again = party.net().start({});
      party.net().move(again, party.net().place_of(0));
      party.run(10);
      EXPECT_TRUE(party.noted(1, "the founder is gone, and play has not begun: joining anew")) << party.story();
      EXPECT_FALSE(party.noted(0, "joining them")) << "it leaves";
      EXPECT_FALSE(party.started());
      party.net().start(0);
      ASSERT_TRUE(party.run_until(10, [&] { return party.started() && party.united(); })) << party.story();
      for (int p = 1; p < 3; ++p) {
        EXPECT_EQ(party.net().peer(p).incarnation(), 1);
        EXPECT_EQ(party.net().peer(p).session().number(), party.net().peer(again).session().number());
        EXPECT_FALSE(party.noted(p, "here and there")) << "two sessions have nothing in common";
      }
      party.run(5);
      EXPECT_TRUE(party.united()) << party.story();
    }
}

// Once, it waited for those who played on without it, and said nothing.
TEST(SessionStart, AFounderThatIsStartedAnewWhileTheOthersPlayIsToldWhereTheyAre) {
  Party party = waiting(3, 3);
  ASSERT_TRUE(party.run_until(8, [&] { return party.started(); }));
  party.run(2);
  party.net().kill(0);
  const int again = party.net().start({});
  party.net().move(again, party.net().place_of(0));
  party.run(4);
  EXPECT_FALSE(party.noted(again, "another session"));
  party.run(6);
  EXPECT_TRUE(party.noted(again, "is in another session; to come into that one, start this peer with --join 10.0.0."))
      << party.story();
  EXPECT_FALSE(party.noted(1, "another session"));
}

TEST(SessionStart, WhoeverElseLeavesBeforePlayIsNotLookedFor) {
  Party party = waiting(5, 3);
  party.run(5);
  party.net().start(1);
  party.run(3);
  party.net().kill(1);
  party.run(20);
  EXPECT_EQ(party.net().peer(3).incarnation(), 0) << party.story();
  EXPECT_FALSE(party.noted(3, "joining anew")) << party.story();
}

}  // namespace
}  // namespace padr::test
