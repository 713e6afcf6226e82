// What somebody who is no member may send, to a peer that waits for others and to one that plays.
#include <gtest/gtest.h>

#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

const Endpoint kStranger = ipv4({10, 0, 0, 66}, 7000);

/// One of each kind, with values that a peer of the session could send.
std::vector<wire::SessionMessage> one_of_each() {
  return {wire::Join{1, 0x5CE4E, 0xF14, true, "arena seed 1"},
          wire::Welcome{1, 1, 2, 2, 7, 9},
          wire::Redirect{1, ipv4({10, 0, 0, 3}, 7000)},
          wire::Refuse{1, "no"},
          wire::Ping{123},
          wire::Pong{123, 456}};
}

wire::Bytes sealed(const wire::SessionMessage& m, std::uint16_t session, PeerId sender = 0) {
  return wire::seal({wire::Kind::kSession, sender, session}, wire::encode_session(m));
}

/// A founder and another member, playing or waiting for a third; counts what they send to others than one another.
class Pair {
 public:
  explicit Pair(bool playing)
      : party_(
            config(playing),
            [this](lab::VirtualNetwork& net) {
              net.on_start = [this](int, node::ParticipantConfig& c) {
                c.tamper = [this](node::Parcel p) {
                  if (p.to != party_.net().place_of(0) && p.to != party_.net().place_of(1)) ++strangers_;
                  return std::vector{std::move(p)};
                };
              };
            },
            2) {
    EXPECT_TRUE(party_.run_until(5, [&] { return party_.united() && party_.started() == playing; })) << party_.story();
    party_.run(2);
  }
  void inject(const Endpoint& from, int to, const wire::Bytes& datagram) { party_.net().inject(from, to, datagram); }
  void run(double seconds) { party_.run(seconds); }
  std::uint64_t to_strangers() const { return strangers_; }
  std::uint16_t number() const { return party_.net().peer(0).session().number(); }
  const node::SessionStats& stats(int person) const { return party_.net().peer(person).session().stats(); }
  const Endpoint& place(int person) const { return party_.net().place_of(person); }
  void expect_no_harm(bool playing) const {
    EXPECT_TRUE(party_.united()) << party_.story();
    EXPECT_EQ(party_.started(), playing);
    EXPECT_EQ(party_.judge().violation(), "");
    for (int p = 0; p < 2; ++p) {
      EXPECT_EQ(party_.net().peer(p).incarnation(), 0) << party_.story();
      EXPECT_EQ(party_.net().peer(p).session().present(), 2);
    }
  }

 private:
  static lab::VirtualNetworkConfig config(bool playing) { return party_config(playing ? 2 : 3, "delay 5ms", 1, 4); }

  std::uint64_t strangers_ = 0;
  Party party_;
};

// A Join without its padding got a Refuse five times its size.
TEST(Strangers, AnUnpaddedJoinGetsNoAnswer) {
  Pair pair(true);
  wire::Bytes payload(11, std::byte{0});
  payload[0] = std::byte{0x0A};  // Join, 9 bytes: nonce = 1
  payload[1] = std::byte{9};
  payload[2] = std::byte{0x09};
  payload[3] = std::byte{1};
  for (const int target : {0, 1})
    pair.inject(kStranger, target, wire::seal({wire::Kind::kSession, kNoPeer, 0}, payload));
  pair.run(0.2);
  EXPECT_EQ(pair.to_strangers(), 0U);
}

TEST(Strangers, AnswersAreLimited) {
  Pair pair(true);
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    Endpoint from = kStranger;
    from.port = static_cast<std::uint16_t>(1000 + i);
    pair.inject(from, 0, sealed(wire::Join{i + 1, 0, 0, true, "x"}, 0));
  }
  pair.run(0.05);
  EXPECT_GT(pair.to_strangers(), 10U);
  EXPECT_LE(pair.to_strangers(), 60U);
}

TEST(Strangers, WhoProvesNothingDoesNotKeepOthersOut) {
  lab::VirtualNetworkConfig config = party_config(4, "delay 5ms", 1);
  config.slots = 4;
  Party party(config, {}, 1);
  party.run(0.1);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Endpoint from = kStranger;
    from.port = static_cast<std::uint16_t>(1000 + i);
    party.net().inject(from, 0, sealed(wire::Join{i + 1, scene_hash(config.scene), 1, true, ""}, 0));
  }
  party.run(0.1);
  EXPECT_EQ(party.net().peer(0).session().present(), 1);
  for (int n = 0; n < 3; ++n) party.net().start(0);
  EXPECT_TRUE(party.run_until(8, [&] { return party.started() && party.united(); })) << party.story();
}

TEST(Strangers, OnlyTheRightAddressSpeaksForAMember) {
  Pair pair(true);
  const std::vector<std::byte> payload(10);
  Endpoint other_port = pair.place(1);
  ++other_port.port;
  struct Case {
    const char* what;
    Endpoint from;
    PeerId sender;
    int session;  ///< added to the session's number
  };
  for (const Case& c : {Case{"claims to be us", pair.place(1), 0, 0}, Case{"somebody else", pair.place(1), 2, 0},
                        Case{"of another session", pair.place(1), 1, 1}, Case{"of a stranger", kStranger, 1, 0},
                        Case{"of another port", other_port, 1, 0}}) {
    const node::SessionStats before = pair.stats(0);
    pair.inject(
        c.from, 0,
        wire::seal({wire::Kind::kState, c.sender, static_cast<std::uint16_t>(pair.number() + c.session)}, payload));
    pair.run(0.01);
    EXPECT_EQ(pair.stats(0).foreign, before.foreign + 1) << c.what;
  }
  const node::SessionStats before = pair.stats(0);
  pair.inject(pair.place(1), 0, wire::seal({wire::Kind::kState, 1, pair.number()}, payload));
  pair.run(0.01);
  EXPECT_EQ(pair.stats(0).foreign, before.foreign);
  EXPECT_GT(pair.stats(0).state, before.state);
}

TEST(Strangers, CannotTalkAMemberOutOfTheSession) {
  for (const bool playing : {false, true}) {
    Pair pair(playing);
    for (const int target : {0, 1}) {
      for (const auto& m : one_of_each()) {
        pair.inject(kStranger, target, sealed(m, pair.number()));
        pair.inject(pair.place(1 - target), target, sealed(m, static_cast<std::uint16_t>(pair.number() ^ 1U)));
      }
    }
    pair.run(2);
    pair.expect_no_harm(playing);
  }
}

// Bytes cut, flipped and made up, with a right tag so that they get as far as they can.
TEST(Strangers, GarbageIsCountedAndChangesNothing) {
  const std::uint64_t seed = test::seed(11);
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  const auto messages = one_of_each();
  for (const bool playing : {false, true}) {
    Pair pair(playing);
    for (int round = 0; round < 20'000; ++round) {
      wire::Bytes payload = wire::encode_session(messages[rng.below(static_cast<std::uint32_t>(messages.size()))]);
      if (rng.chance(0.5)) payload.resize(rng.below(static_cast<std::uint32_t>(payload.size())));
      for (std::uint32_t flips = rng.below(4); flips > 0 && !payload.empty(); --flips)
        payload[rng.below(static_cast<std::uint32_t>(payload.size()))] ^= static_cast<std::byte>(1U << rng.below(8));
      const auto kind = rng.chance(0.2) ? wire::Kind::kState : wire::Kind::kSession;
      const auto number = rng.chance(0.5) ? pair.number() : static_cast<std::uint16_t>(rng.next_u32());
      wire::Bytes d = wire::seal({kind, static_cast<PeerId>(rng.below(256)), number}, payload);
      if (rng.chance(0.1)) d.resize(rng.below(static_cast<std::uint32_t>(d.size() + 1)));
      if (rng.chance(0.05)) d.resize(d.size() + 2000);
      pair.inject(kStranger, static_cast<int>(rng.below(2)), d);
      if (round % 200 == 0) pair.run(0.02);
    }
    pair.run(2);
    pair.expect_no_harm(playing);
    for (const int n : {0, 1}) {
      const node::SessionStats& s = pair.stats(n);
      EXPECT_GT(s.malformed, 100U);
      EXPECT_GT(s.seal, 100U);
      EXPECT_EQ(s.datagrams, s.state + s.session + s.seal + s.version + s.foreign + s.malformed);
    }
  }
}

}  // namespace
}  // namespace padr::test
