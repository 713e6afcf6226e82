// Coming into a running session, and leaving it.
#include "common/wire/membership_codec.h"
#include "common/wire/seal.h"
#include "tests/membership/party.h"

namespace padr::test {
namespace {

TEST(Joining, ANewcomerPlaysWithinASecondAndConfirmsTheSameWorld) {
  Party party(3, "delay 50ms", 11);
  party.run(10);
  const int newcomer = party.net().start(2);  // not the coordinator: it is passed on
  party.run(3);
  ASSERT_TRUE(party.net().peer(newcomer).playing()) << party.story();
  const double took = static_cast<double>(party.net().took(newcomer)) / 1e6;
  RecordProperty("join_s", std::to_string(took));
  EXPECT_LE(took, 1.0) << party.story();
  const std::uint64_t before = party.judge().compared();
  party.run(5);
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
  EXPECT_GT(party.judge().compared(), before + 3 * 200);
  EXPECT_LT(party.lag(newcomer), 120);
}

TEST(Joining, NobodyElseStallsMeanwhile) {
  Party party(3, "delay 50ms 10ms loss 2%", 12);
  party.run(10);
  std::vector<Tick> last(3, 0);
  Micros last_at = party.net().now();
  party.net().start(0);
  for (int i = 0; i < 500; ++i) {
    party.net().run_to(party.net().now() + lab::VirtualNetwork::kStep);
    for (int p = 0; p < 3; ++p) {
      const Tick now = party.replica(p).now();
      if (last[static_cast<std::size_t>(p)] != 0) {
        EXPECT_LE(now - last[static_cast<std::size_t>(p)], 2) << "at " << last_at;
      }
      last[static_cast<std::size_t>(p)] = now;
    }
    last_at = party.net().now();
  }
  EXPECT_TRUE(party.united()) << party.story();
}

TEST(Joining, LossOnlyTakesTime) {
  Party party(2, "delay 60ms 30ms loss 30%", 13);
  party.run(8);
  const int newcomer = party.net().start(1);
  const auto took = party.run_until(20, [&] { return party.united(); });
  ASSERT_TRUE(took.has_value()) << party.story();
  party.run(10);
  EXPECT_EQ(party.judge().violation(), "");
  EXPECT_TRUE(party.net().runs(newcomer));
}

TEST(Joining, ManyAtOnceGetSlotsOfTheirOwn) {
  Party party(2, "delay 40ms 10ms loss 3%", 14);
  party.run(5);
  for (int i = 0; i < 6; ++i) party.net().start(i % 2);
  const auto took = party.run_until(10, [&] { return party.united(); });
  ASSERT_TRUE(took.has_value()) << party.story();
  party.run(5);
  EXPECT_EQ(party.judge().violation(), "");
}

// So that a slow machine, or a narrow link, is not overloaded by all of them together.
TEST(Joining, ACrowdTakesTurns) {
  std::set<Endpoint> given;  // a piece of the world
  std::size_t most = 0;
  Party* running = nullptr;
  lab::VirtualNetworkConfig config = party_config(2, "delay 40ms 10ms loss 3%", 15);
  config.slots = 24;
  Party party(
      config,
      [&](lab::VirtualNetwork& net) {
        net.on_start = [&](int person, node::ParticipantConfig& c) {
          if (person != 0) return;
          c.tamper = [&](node::Parcel p) {
            wire::SealError error = wire::SealError::kNone;
            const auto o = wire::open(p.bytes, error);
            const auto m =
                o && o->header.kind == wire::Kind::kMembership ? wire::decode_membership(o->payload) : std::nullopt;
            if (running != nullptr && m && std::holds_alternative<wire::Piece>(*m)) {
              given.insert(p.to);
              most = std::max(most,
                              given.size() - static_cast<std::size_t>(running->net().peer(0).session().present() - 2));
            }
            return std::vector{std::move(p)};
          };
        };
      },
      2);
  party.run(3);
  given.clear();
  running = &party;
  for (int i = 0; i < 20; ++i) party.net().start(0);
  const auto took = party.run_until(10, [&] { return party.united(); });
  ASSERT_TRUE(took.has_value()) << party.story();
  EXPECT_EQ(given.size(), 20U);
  EXPECT_LE(most, 8U) << "four, and those whose admission is under way";
  party.run(2);
  EXPECT_EQ(party.judge().violation(), "");
}

// The first of them gets the founder's slot, and is no more senior for that.
TEST(Joining, SeveralAtOnceAllComeInWhereTheFoundersSlotIsFree) {
  for (std::uint64_t seed = 60; seed < 70; ++seed) {
    Party party(3, "delay 40ms 10ms loss 5%", seed);
    party.run(5);
    party.net().leave(0);
    party.run(5);
    const PeerId coordinator = party.net().peer(1).coordinator();
    for (int i = 0; i < 4; ++i) {
      party.net().start(1 + i % 2);
      party.run(0.1);
    }
    const auto took = party.run_until(3.5, [&] { return party.united(); });
    ASSERT_TRUE(took.has_value()) << "seed " << seed << "\n" << party.story();
    for (int p = 1; p < 7; ++p) EXPECT_EQ(party.net().peer(p).coordinator(), coordinator) << p;
    EXPECT_TRUE(party.replica(1).seat(0).there());
    party.run(2);
    EXPECT_EQ(party.judge().violation(), "");
  }
}

TEST(Joining, AFullSessionRefuses) {
  lab::VirtualNetworkConfig config = party_config(2, "delay 10ms", 15);
  config.slots = 2;
  Party party(std::move(config));
  party.run(5);
  const int newcomer = party.net().start(0);
  party.run(3);
  EXPECT_FALSE(party.net().runs(newcomer));
  EXPECT_NE(party.net().peer(newcomer).session().failure().find("the session is full: 2 of 2 slots"), std::string::npos)
      << party.net().peer(newcomer).session().failure();
}

// Once, it was refused at once: nobody had missed the process before yet.
TEST(Joining, WhoIsStartedAnewAfterACrashComesIntoAFullSession) {
  for (const double after : {0.0, 0.3, 0.9}) {
    lab::VirtualNetworkConfig config = party_config(3, "delay 10ms", 17);
    config.slots = 3;
    Party party(std::move(config));
    party.run(5);
    party.net().kill(2);
    party.run(after);
    const int again = party.net().start(1);
    ASSERT_TRUE(party.run_until(10, [&] { return party.net().runs(again) && party.united(); })) << party.story();
    EXPECT_EQ(party.judge().violation(), "");
  }
}

TEST(Joining, ASlotThatWasLeftIsTakenAgain) {
  lab::VirtualNetworkConfig config = party_config(3, "delay 30ms", 16);
  config.slots = 3;
  Party party(std::move(config));
  party.run(5);
  party.net().leave(1);
  party.run(5);
  EXPECT_FALSE(party.net().runs(1));
  party.net().start(0);
  const auto took = party.run_until(5, [&] { return party.united() && party.net().persons() == 4; });
  ASSERT_TRUE(took.has_value()) << party.story();
  party.run(5);
  EXPECT_EQ(party.judge().violation(), "");
  EXPECT_GT(party.replica(3).config().incarnation, 0U);
}

// The number of slots is told by the founder: another version of the program might say one that does not fit the
// scenario.
TEST(Joining, MoreSlotsThanPlacesToStartFromAreRefused) {
  lab::VirtualNetworkConfig config = party_config(2, "delay 10ms", 19);
  config.scene.avatar.spawns.resize(2);
  config.slots = 2;
  const auto another_version = [](node::Parcel parcel) {
    wire::SealError error{};
    const auto opened = wire::open(parcel.bytes, error);
    auto message = opened->header.kind == wire::Kind::kSession ? wire::decode_session(opened->payload) : std::nullopt;
    if (message && std::holds_alternative<wire::Welcome>(*message)) {
      std::get<wire::Welcome>(*message).slots = 3;
      parcel.bytes = wire::seal(opened->header, wire::encode_session(*message));
    }
    return std::vector<node::Parcel>{std::move(parcel)};
  };
  Party party(std::move(config), [&](lab::VirtualNetwork& g) {
    g.on_start = [&](int, node::ParticipantConfig& c) { c.tamper = another_version; };
  });
  party.run(3);
  EXPECT_FALSE(party.net().peer(1).playing());
  EXPECT_NE(party.net().peer(1).session().failure().find("more avatar slots (3)"), std::string::npos)
      << party.net().peer(1).session().failure();
}

// Peers 0 and 2 run on one machine, and know one another by its loopback address. What others are told of them, by
// whomever, says which machine that is.
TEST(Joining, ALoopbackAddressMeansTheMachineOfWhoToldItFirst) {
  lab::VirtualNetworkConfig config = party_config(2, "delay 20ms", 23);
  config.host = [](int person) { return person == 2 ? 0 : person; };
  Party party(std::move(config));
  party.run(5);
  party.net().start(0, true);
  ASSERT_TRUE(party.run_until(5, [&] { return party.united(); }).has_value()) << party.story();
  party.net().leave(0);
  party.run(3);
  const int newcomer = party.net().start(1);
  ASSERT_TRUE(party.run_until(5, [&] { return party.united(); }).has_value()) << party.story();
  party.run(6);
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_EQ(party.story().find("is lost"), std::string::npos) << party.story();
  const node::Replica& n = party.replica(newcomer);
  EXPECT_EQ(n.seat(party.replica(2).self()).at, party.net().place_of(2));
  EXPECT_EQ(party.judge().violation(), "");
}

// A clock that is 500 ppm off is 30 ms off after a minute.
TEST(Joining, ClocksThatDriftAreSteered) {
  lab::VirtualNetworkConfig config = party_config(2, "delay 20ms", 9, 2);
  config.most_ppm = 400;
  Party party(std::move(config));
  party.run(40);
  const auto apart = [&] { return std::abs(party.net().session_now(0) - party.net().session_now(1)); };
  Micros most = apart();
  for (int i = 0; i < 40; ++i) {
    party.run(0.5);
    most = std::max(most, apart());
  }
  EXPECT_LT(most, kMicrosPerSecond / kTicksPerSecond) << "us, a tick";
  EXPECT_GT(std::abs(party.net().rate(0) - party.net().rate(1)), 500e-6) << "or nothing was steered";
}

// Once, what all of them said from out there was refused by all, and so was a newcomer's transfer.
TEST(Joining, WhoWalksOutOfASceneWithoutWallsIsHeardThere) {
  lab::VirtualNetworkConfig config = party_config(3, "delay 30ms 5ms", 5);
  config.scene.statics.clear();
  Party party(std::move(config));
  for (int i = 0; i < 12; ++i) {
    party.net().attract(Vec2{60.0F + static_cast<float>(i % 3) * 3, 5});
    party.run(1);
  }
  const node::Replica& n = party.replica(0);
  EXPECT_GT(n.live().world().position(n.live().avatar()).x, n.live().world().scene().upper.x + 18);
  EXPECT_EQ(n.stats().dropped[static_cast<std::size_t>(sync::DropReason::kValue)], 0U);
  party.net().start(0);
  EXPECT_TRUE(party.run_until(5, [&] { return party.united(); }).has_value()) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
}

// Once, it was 1.5 s behind for five minutes, and so was every confirmed world.
TEST(Joining, AClockThatHasStoodStillIsSetRightAtOnce) {
  for (const int person : {0, 2}) {
    Party party(4, "delay 30ms 5ms loss 1%", 23);
    party.run(8);
    party.net().pause(person, true);
    party.run(1.5);
    party.net().stand_still(person, seconds(1.5));
    party.net().pause(person, false);
    party.run(6);
    const int another = 3;
    EXPECT_LT(std::abs(party.net().session_now(person) - party.net().session_now(another)), kMicrosPerSecond / 5);
    EXPECT_EQ(party.story().find("is lost"), std::string::npos) << party.story();
    EXPECT_EQ(party.story().find("joining anew"), std::string::npos) << party.story();
    party.run(20);
    EXPECT_LT(std::abs(party.net().session_now(person) - party.net().session_now(another)), kMicrosPerSecond / 20);
    EXPECT_EQ(party.judge().violation(), "");
  }
}

TEST(Joining, TheFounderMayLeave) {
  Party party(3, "delay 30ms 5ms loss 1%", 17);
  party.run(5);
  party.net().leave(0);
  party.run(5);
  party.net().start(2);
  const auto took = party.run_until(5, [&] { return party.united(); });
  ASSERT_TRUE(took.has_value()) << party.story();
  party.run(3);
  EXPECT_EQ(party.judge().violation(), "");
}

}  // namespace
}  // namespace padr::test
