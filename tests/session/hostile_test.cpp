#include <gtest/gtest.h>

#include "tests/seed.h"
#include "tests/session/virtual_net.h"

namespace padr::test {
namespace {

using node::SessionPhase;

/// One of each kind, with values that a peer of the session could send.
std::vector<wire::SessionMessage> one_of_each() {
  return {wire::Join{1, 0x5CE4E, 0xF14, true, "arena seed 1"},
          wire::Welcome{1, 1, 2, 2},
          wire::Redirect{1, place(3)},
          wire::Refuse{1, "no"},
          wire::Ping{123},
          wire::Pong{123, 456, 2},
          wire::Start{1'000'000, {Endpoint{}, place(2)}},
          wire::Ready{1000, true},
          wire::Bye{"going"}};
}

/// A founder at 1 and a member at 2, gathering or started.
std::unique_ptr<VirtualNet> pair(bool started) {
  auto net = std::make_unique<VirtualNet>(1);
  node::SessionConfig f = alike(1);
  f.wanted = f.slots = started ? 2 : 3;
  node::SessionConfig j = alike(2);
  j.join = place(1);
  net->add(1, f);
  net->add(2, j);
  net->run(2'000'000);
  EXPECT_TRUE(net->all(started ? SessionPhase::kStarted : SessionPhase::kGathering));
  return net;
}

wire::Bytes sealed(const wire::SessionMessage& m, std::uint16_t session, PeerId sender = 0) {
  return wire::seal({wire::Kind::kSession, sender, session}, wire::encode_session(m));
}

TEST(Hostile, NoAnswerIsLargerThanWhatProvokedIt) {
  for (const bool started : {false, true}) {
    const auto net = pair(started);
    for (const int target : {1, 2}) {
      for (const auto& m : one_of_each()) {
        for (const std::uint16_t number : {std::uint16_t{0}, net->at(1).number()}) {
          net->at(target).take_outgoing();
          const wire::Bytes d = sealed(m, number, kNoPeer);
          net->inject(place(66), target, d);
          for (const auto& out : net->at(target).take_outgoing())
            EXPECT_LE(out.bytes.size(), d.size()) << "message kind " << m.index() << " at " << target;
        }
      }
    }
  }
}

// A Join without its padding got a Refuse five times its size.
TEST(Hostile, AnUnpaddedJoinGetsNoAnswer) {
  const auto net = pair(true);
  wire::Bytes payload(11, std::byte{0});
  payload[0] = std::byte{0x0A};  // Join, 9 bytes: nonce = 1
  payload[1] = std::byte{9};
  payload[2] = std::byte{0x09};
  payload[3] = std::byte{1};
  for (const int target : {1, 2}) {
    net->at(target).take_outgoing();
    net->inject(place(66), target, wire::seal({wire::Kind::kSession, kNoPeer, 0}, payload));
    for (const auto& out : net->at(target).take_outgoing()) EXPECT_NE(out.to, place(66)) << target;
  }
}

TEST(Hostile, AnswersToStrangersAreLimited) {
  const auto net = pair(true);
  std::size_t answers = 0;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    Endpoint from = place(66);
    from.port = static_cast<std::uint16_t>(1000 + i);
    wire::Join join{i + 1, 0, 0, true, "x"};
    net->inject(from, 1, sealed(join, 0));
    answers += net->at(1).take_outgoing().size();
  }
  EXPECT_LE(answers, 60U);
}

TEST(Hostile, NewcomersThatProveNothingDoNotKeepOthersOut) {
  VirtualNet net(1);
  node::SessionConfig f = alike(1);
  f.wanted = f.slots = 4;
  net.add(1, f);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Endpoint from = place(66);
    from.port = static_cast<std::uint16_t>(1000 + i);
    net.inject(from, 1, sealed(wire::Join{i + 1, f.scene_hash, f.fingerprint, true, ""}, 0));
  }
  EXPECT_EQ(net.at(1).present(), 1);
  for (int n = 2; n <= 4; ++n) {
    node::SessionConfig c = alike(static_cast<std::uint64_t>(n));
    c.join = place(1);
    net.add(n, c);
  }
  EXPECT_TRUE(net.run(8'000'000, [&] { return net.all(SessionPhase::kStarted); })) << net.story();
}

TEST(Hostile, OnlyTheRightAddressSpeaksForAMember) {
  const auto net = pair(true);
  const std::uint16_t number = net->at(1).number();
  const std::vector<std::byte> payload(10);
  const auto state = [&](PeerId sender, std::uint16_t session) {
    return wire::seal({wire::Kind::kState, sender, session}, payload);
  };
  EXPECT_EQ(net->inject(place(2), 1, state(1, number)), PeerId{1});
  EXPECT_EQ(net->inject(place(1), 2, state(0, number)), PeerId{0});
  EXPECT_EQ(net->inject(place(2), 1, state(0, number)), std::nullopt) << "claims to be us";
  EXPECT_EQ(net->inject(place(2), 1, state(2, number)), std::nullopt) << "claims to be somebody else";
  EXPECT_EQ(net->inject(place(2), 1, state(1, static_cast<std::uint16_t>(number + 1))), std::nullopt);
  EXPECT_EQ(net->inject(place(3), 1, state(1, number)), std::nullopt);
  Endpoint other_port = place(2);
  ++other_port.port;
  EXPECT_EQ(net->inject(other_port, 1, state(1, number)), std::nullopt);
  EXPECT_EQ(net->at(1).stats().foreign, 5U);
}

TEST(Hostile, StrangersCannotTalkAMemberOutOfTheSession) {
  for (const bool started : {false, true}) {
    const auto net = pair(started);
    const auto phase = net->at(2).phase();
    const auto present = net->at(1).present();
    for (const int target : {1, 2}) {
      for (const auto& m : one_of_each()) {
        if (std::holds_alternative<wire::Join>(m)) continue;
        net->inject(place(66), target, sealed(m, net->at(1).number()));
        net->inject(place(3 - target), target, sealed(m, static_cast<std::uint16_t>(net->at(1).number() ^ 1U)));
      }
      EXPECT_EQ(net->at(target).phase(), phase);
      EXPECT_EQ(net->at(1).present(), present);
    }
  }
}

// Bytes cut, flipped and made up, with a right tag so that they get as far as they can, thrown at every phase.
TEST(Hostile, GarbageIsCountedAndChangesNothing) {
  const std::uint64_t seed = test::seed(11);
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (const bool started : {false, true}) {
    const auto net = pair(started);
    for (int round = 0; round < 20'000; ++round) {
      const auto messages = one_of_each();
      wire::Bytes payload = wire::encode_session(messages[rng.below(static_cast<std::uint32_t>(messages.size()))]);
      const std::size_t before = payload.size();
      if (rng.chance(0.5)) payload.resize(rng.below(static_cast<std::uint32_t>(payload.size())));
      for (std::uint32_t flips = rng.below(4); flips > 0 && !payload.empty(); --flips)
        payload[rng.below(static_cast<std::uint32_t>(payload.size()))] ^= static_cast<std::byte>(1U << rng.below(8));
      ASSERT_LE(payload.size(), before);
      const auto kind = rng.chance(0.2) ? wire::Kind::kState : wire::Kind::kSession;
      const auto number = rng.chance(0.5) ? net->at(1).number() : static_cast<std::uint16_t>(rng.next_u32());
      wire::Bytes d = wire::seal({kind, static_cast<PeerId>(rng.below(256)), number}, payload);
      if (rng.chance(0.1)) d.resize(rng.below(static_cast<std::uint32_t>(d.size() + 1)));
      if (rng.chance(0.05)) d.resize(d.size() + 2000);
      net->inject(place(66), static_cast<int>(1 + rng.below(2)), d);
    }
    EXPECT_TRUE(net->all(started ? SessionPhase::kStarted : SessionPhase::kGathering));
    for (const int n : {1, 2}) {
      const node::SessionStats& s = net->at(n).stats();
      EXPECT_GT(s.malformed, 100U);
      EXPECT_GT(s.seal, 100U);
      EXPECT_EQ(s.datagrams, s.state + s.session + s.seal + s.version + s.foreign + s.malformed);
    }
  }
}

}  // namespace
}  // namespace padr::test
