// How a session begins: its founder and whoever comes wait for one another in it, and play begins for all at one tick.
#include <gtest/gtest.h>

#include <set>

#include "tests/membership/party.h"
#include "tests/seed.h"
#include "tests/session/waiting.h"

namespace padr::test {
namespace {

/// The numbers of all who run, if everybody knows everybody at the right place; empty otherwise.
std::set<PeerId> mesh(const Party& party) {
  std::set<PeerId> numbers;
  for (int p = 0; p < party.net().persons(); ++p) {
    numbers.insert(party.replica(p).self());
    for (int q = 0; q < party.net().persons(); ++q)
      if (q != p && party.replica(p).seat(party.replica(q).self()).at != party.net().place_of(q)) return {};
  }
  return numbers;
}

TEST(SessionStart, OnePeerAloneStartsAtOnce) {
  Party party = waiting(1, 1);
  party.run(0.1);
  EXPECT_TRUE(party.started());
  EXPECT_EQ(party.replica(0).self(), 0);
  EXPECT_EQ(party.replica(0).start().at, 0);
}

TEST(SessionStart, AllBeginAtTheSameTickAndKnowWellBefore) {
  Party party = waiting(2, 2);
  const auto told = [&](int p) { return party.net().peer(p).playing() && party.replica(p).start().wanted == 0; };
  ASSERT_TRUE(party.run_until(3, [&] { return told(0) && told(1); })) << party.story();
  for (int p = 0; p < 2; ++p) EXPECT_GT(party.replica(p).start().at - party.replica(p).now(), sync::kStartLead / 2);
  ASSERT_TRUE(party.run_until(2, [&] { return party.started(); })) << party.story();
  EXPECT_EQ(mesh(party), (std::set<PeerId>{0, 1}));
  EXPECT_LT(std::abs(party.net().session_now(0) - party.net().session_now(1)), kMicrosPerSecond / kTicksPerSecond);
}

TEST(SessionStart, AsManyAsTheSceneHasRoomForOverABadNetwork) {
  lab::VirtualNetworkConfig config = party_config(2, "delay 60ms 30ms loss 10%", 7, 4);
  config.slots = config.wanted = static_cast<int>(config.scene.avatar.spawns.size());
  ASSERT_GE(config.wanted, 16);
  Party party(config);
  ASSERT_TRUE(party.run_until(20, [&] { return party.started(); })) << party.story();
  EXPECT_EQ(mesh(party).size(), static_cast<std::size_t>(config.wanted));
  EXPECT_EQ(party.judge().violation(), "");
}

// What is asked for again before it can have come would fill the link.
TEST(SessionStart, OverNarrowLinks) {
  lab::VirtualNetworkConfig config = party_config(2, "delay 50ms rate 32kbit limit 100", seed(1));
  config.scene = scenarios::load_embedded("arena", 1);
  config.seal = wire::SealMode::kAuth;
  Party party(config);
  EXPECT_TRUE(party.run_until(10, [&] { return party.started(); })) << party.story();
  EXPECT_EQ(party.judge().violation(), "") << party.story();
}

TEST(SessionStart, LossDuplicatesReorderingAndCorruption) {
  const std::uint64_t first = seed(1);
  for (std::uint64_t seed = first; seed < first + 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Party party = waiting(4, 4, "delay 100ms 50ms loss 30% duplicate 10% reorder 5% corrupt 1%", seed);
    ASSERT_TRUE(party.run_until(25, [&] { return party.started(); })) << party.story();
    EXPECT_EQ(mesh(party), (std::set<PeerId>{0, 1, 2, 3}));
    party.run(5);
    EXPECT_EQ(party.judge().violation(), "") << party.story();
  }
}

// Jitter of one way only, and as much of it as there is: the least delays are alike, so the clocks are too.
TEST(SessionStart, ClocksAgreeWithinATickUnderAsymmetricJitter) {
  const std::uint64_t first = seed(1);
  for (std::uint64_t seed = first; seed < first + 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Party party(party_config(4, "delay 120ms 100ms loss 30% duplicate 10%", seed), [](lab::VirtualNetwork& net) {
      for (int p = 1; p < 4; ++p) net.shape(0, p, shell::parse_netem("delay 25ms 5ms loss 30%"));
    });
    ASSERT_TRUE(party.run_until(25, [&] { return party.started(); })) << party.story();
    party.run(6);
    for (int p = 1; p < 4; ++p)
      EXPECT_LE(std::abs(party.net().session_now(0) - party.net().session_now(p)), kMicrosPerSecond / kTicksPerSecond);
  }
}

TEST(SessionStart, AskingIsBoundedWhereNobodyIs) {
  int asked = 0;
  Party party(party_config(2, "delay 10ms", 1), [&](lab::VirtualNetwork& net) {
    net.on_start = [&](int person, node::ParticipantConfig& c) {
      c.tamper = [&asked, person](node::Parcel p) {
        asked += person;
        return std::vector{std::move(p)};
      };
    };
  });
  party.net().kill(0);
  party.run(10);
  EXPECT_LE(asked, 10 * 6);
  EXPECT_GE(asked, 10 * 2);
}

TEST(SessionStart, EverybodyIsLearnedThroughAnyMember) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Party party = waiting(4, 2, "delay 30ms 10ms loss 20%", seed);
    party.net().start(1);
    party.net().start(2);  // through one that is not in yet itself
    ASSERT_TRUE(party.run_until(20, [&] { return party.started(); })) << party.story();
    EXPECT_EQ(mesh(party).size(), 4U);
    EXPECT_TRUE(party.noted(2, "passes us on")) << party.story();
  }
}

// Bodies that move at tick 0 by the scenario wait, too, whatever the technique.
TEST(SessionStart, NothingMovesUntilTheLastIsThere) {
  for (const char* technique : {"full", "adaptive", "avatar-only"}) {
    SCOPED_TRACE(technique);
    lab::VirtualNetworkConfig config = party_config(3, "delay 40ms 10ms loss 5%", 3);
    config.technique = technique_by_name(technique);
    config.scene.bodies[0].velocity = {1, 0};
    Party party(config, {}, 2);
    party.run(8);
    const auto still = [&](int person) {
      const world::View& live = party.replica(person).live().world();
      bool same = true;
      for (EntityId b = 0; b < live.bodies(); ++b) same &= live.position(b) == config.scene.bodies[b].position;
      return same && live.position(live.avatar(party.replica(person).self())) ==
                         config.scene.avatar.spawns[party.replica(person).self()];
    };
    EXPECT_EQ(party.net().peer(0).session().present(), 2);
    EXPECT_EQ(party.net().peer(1).session().present(), 2);
    EXPECT_TRUE(still(0) && still(1));
    EXPECT_FALSE(party.replica(0).may_push(0));
    party.net().start(0);
    ASSERT_TRUE(party.run_until(4, [&] { return party.started(); })) << party.story();
    party.run(4);
    for (int p = 0; p < 3; ++p) EXPECT_FALSE(still(p)) << p;
    EXPECT_EQ(party.judge().violation(), "");
    EXPECT_GT(party.judge().compared(), 300U);
  }
}

TEST(SessionStart, WhoeverHearsOfItLateIsOneWorldWithTheOthers) {
  Party party = waiting(3, 2, "delay 20ms");
  party.run(3);
  party.net().start(0);
  ASSERT_TRUE(party.run_until(4, [&] { return party.net().peer(0).session().present() == 3; })) << party.story();
  for (const int from : {0, 2}) party.net().cut(from, 1, true);
  party.run(1.8);
  EXPECT_TRUE(party.replica(0).playing());
  EXPECT_FALSE(party.replica(1).playing());
  for (const int from : {0, 2}) party.net().cut(from, 1, false);
  ASSERT_TRUE(party.run_until(3, [&] { return party.started(); })) << party.story();
  party.run(4);
  EXPECT_EQ(party.judge().violation(), "");
  EXPECT_TRUE(party.united()) << party.story();
}

// B's farewell to C gets lost at first, and C hears of D's admission before it: it counts four, though there were
// three.
TEST(SessionStart, AFarewellThatComesLateDoesNotBeginPlay) {
  for (const char* technique : {"full", "adaptive"}) {
    SCOPED_TRACE(technique);
    lab::VirtualNetworkConfig config = party_config(4, "delay 20ms", 5);
    config.technique = technique_by_name(technique);
    Party party(config, {}, 3);
    party.run(3);
    ASSERT_TRUE(party.united()) << party.story();
    for (const int to : {0, 2}) party.net().cut(1, to, to == 2);
    party.net().leave(1);
    party.run(0.4);
    party.net().start(0);
    party.run(4);
    for (const int p : {0, 2, 3}) EXPECT_FALSE(party.replica(p).playing()) << p << party.story();
    party.net().cut(1, 2, false);
    party.net().start(0);
    ASSERT_TRUE(party.run_until(12, [&] { return party.started() && party.united(); })) << party.story();
    party.run(4);
    EXPECT_EQ(party.judge().violation(), "") << party.story();
  }
}

// Whoever is the last that play waits for does not give up because its patience ends in that very second.
TEST(SessionStart, NobodyGivesUpOnceAllAreThere) {
  for (int late = 0; late < 12; ++late) {
    Party party(
        party_config(2, "delay 20ms", 1),
        [&](lab::VirtualNetwork& net) {
          net.on_start = [late](int person, node::ParticipantConfig& c) {
            c.session.patience = person == 1 ? 200'000 + late * 50'000 : 0;
          };
        },
        2);
    party.run(4);
    const bool in = party.net().peer(1).playing();
    EXPECT_EQ(party.net().runs(1), in) << late << " " << party.net().peer(1).session().failure();
    EXPECT_EQ(party.replica(0).playing(), in) << late;
  }
}

TEST(SessionStart, OneThatLeftBeforeItMakesRoom) {
  Party party = waiting(3, 2);
  party.run(1);
  party.net().leave(1);
  party.run(4);
  EXPECT_EQ(party.net().peer(0).session().present(), 1);
  EXPECT_FALSE(party.replica(0).playing());
  party.net().start(0);
  party.run(3);
  EXPECT_FALSE(party.replica(0).playing());
  party.net().start(0);
  EXPECT_TRUE(party.run_until(4, [&] { return party.started(); })) << party.story();
}

TEST(SessionStart, OneThatVanishedBeforeItMakesRoom) {
  Party party = waiting(3, 2);
  party.run(1);
  party.net().kill(1);
  ASSERT_TRUE(party.run_until(8, [&] { return party.net().peer(0).session().present() == 1; })) << party.story();
  party.net().start(0);
  party.run(3);
  EXPECT_FALSE(party.replica(0).playing());
}

TEST(SessionStart, AProgramStartedAnewAtTheSameAddressIsOneMember) {
  Party party = waiting(3, 2);
  party.run(1);
  const Endpoint place = party.net().place_of(1);
  party.net().kill(1);
  party.net().move(1, ipv4({10, 9, 9, 9}, 1));  // makes room for the new one at its place
  const int again = party.net().start(0);
  party.net().move(again, place);
  ASSERT_TRUE(party.run_until(8, [&] { return party.net().peer(again).playing() && party.united(); })) << party.story();
  EXPECT_EQ(party.net().peer(0).session().present(), 2);
  EXPECT_FALSE(party.replica(0).playing());
  party.net().start(0);
  EXPECT_TRUE(party.run_until(4, [&] { return party.started(); })) << party.story();
}

TEST(SessionStart, TimeoutsSayWhy) {
  Party party(
      party_config(3, "delay 10ms", 1),
      [](lab::VirtualNetwork& net) {
        net.on_start = [](int person, node::ParticipantConfig& c) {
          if (person == 0) c.session.patience = 4'000'000;
          if (person == 1) c.session.patience = 7'000'000;
          if (person == 2) c.session.patience = 2'000'000;
          if (person == 2) c.session.join = ipv4({10, 0, 0, 50}, 7000);
        };
      },
      2);
  party.net().start(0);
  const auto failure = [&](int person) { return party.net().peer(person).session().failure(); };
  party.run(1.99);
  EXPECT_TRUE(party.net().runs(2));
  party.run(0.03);
  EXPECT_EQ(failure(2),
            "no answer from 10.0.0.50:7000 within 2 s; it may have a session key, or play in a crowd, nobody "
            "may listen there, or large datagrams get lost");
  ASSERT_TRUE(party.run_until(4, [&] { return !party.net().runs(0); })) << party.story();
  EXPECT_TRUE(party.net().peer(0).failed());
  EXPECT_EQ(failure(0), "only 2 of 3 players came within 4 s");
  ASSERT_TRUE(party.run_until(4, [&] { return !party.net().runs(1); })) << party.story();
  EXPECT_EQ(failure(1), "only 1 of 3 players came within 7 s");
}

// Once, it said nothing until it gave up, and if it never does, nothing at all.
TEST(SessionStart, WhoGetsNoAnswerSaysSoEveryTenSeconds) {
  Party party(
      party_config(2, "delay 10ms", 1),
      [](lab::VirtualNetwork& net) {
        net.on_start = [](int, node::ParticipantConfig& c) {
          c.session.patience = 0;
          c.session.join = ipv4({10, 0, 0, 50}, 7000);
        };
      },
      1);
  party.run(35);
  const std::string story = party.story();
  for (const char* after : {"10 s", "20 s", "30 s"})
    EXPECT_NE(story.find("not in yet: no answer from 10.0.0.50:7000 within " + std::string(after) + "; it may have"),
              std::string::npos)
        << story;
}

// Once, it may have had a session key, or played in a crowd; and whoever had been welcomed waited for 10 s, however
// soon it was to give up.
TEST(SessionStart, WhoIsWelcomedAndNotAdmittedSaysSo) {
  for (const int within : {3, 12}) {
    Party party(
        party_config(2, "delay 10ms", 1),
        [within](lab::VirtualNetwork& net) {
          net.on_start = [within](int, node::ParticipantConfig& c) { c.session.patience = within * kMicrosPerSecond; };
        },
        1);
    party.run(1);
    const int joiner = party.net().start(0);
    const Endpoint at = party.net().place_of(0);
    const auto answered = [&] { return party.net().peer(joiner).session().phase() == node::SessionPhase::kEntering; };
    ASSERT_TRUE(party.run_until(2, answered)) << party.story();
    party.net().kill(0);
    const auto took = party.run_until(within + 1, [&] { return !party.net().runs(joiner); });
    ASSERT_TRUE(took) << party.story();
    EXPECT_LE(*took, within);
    EXPECT_EQ(party.net().peer(joiner).session().failure(),
              "no admission by " + to_string(at) + " within " + std::to_string(within) + " s: " + to_string(at) +
                  " is silent, before this peer was admitted; another member may let it in");
  }
}

TEST(SessionStart, JoiningOneselfIsNoticed) {
  Party party(
      party_config(2, "delay 10ms", 1),
      [](lab::VirtualNetwork& net) {
        net.on_start = [&net](int person, node::ParticipantConfig& c) { c.session.join = net.place_of(person); };
      },
      1);
  party.run(0.5);
  const std::string failure = party.net().peer(0).session().failure();
  EXPECT_NE(failure.find("is this peer itself"), std::string::npos) << failure;
}

// It crashed and comes back through a member that has not missed it yet.
TEST(SessionStart, ACoordinatorThatIsPassedOnToItselfAsksAgain) {
  Party party = waiting(3, 2);
  party.run(1);
  const Endpoint place = party.net().place_of(0);
  party.net().kill(0);
  party.net().move(0, ipv4({10, 9, 9, 9}, 1));
  const int again = party.net().start(1);
  party.net().move(again, place);
  party.run(2);
  EXPECT_TRUE(party.noted(again, "passes us on to " + to_string(place))) << party.story();
  EXPECT_TRUE(party.run_until(10, [&] { return party.net().peer(again).playing(); })) << party.story();
}

}  // namespace
}  // namespace padr::test
