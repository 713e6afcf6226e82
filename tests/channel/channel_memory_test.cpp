// Whom the channels remember, and for whom they forget whom.
#include "common/channel/secure_channels.h"

#include <algorithm>
#include <list>

#include "tests/channel/two_peers.h"

namespace padr::test {
namespace {

using node::ChannelDrop;
using node::SecureChannels;

TEST(SecureChannels, MemoryIsBoundedWhoeverComes) {
  TwoPeers g;
  for (std::uint64_t i = 0; i < SecureChannels::kMostChannels + 50; ++i) {
    SecureChannels other(channel_config(100 + i));
    TwoPeers pair;
    other.send(place(2), kNoPeer, words("in"), g.now);
    for (int round = 0; round < 3; ++round) {
      for (const auto& p : taken(other)) g.b.receive(place(7), p.bytes, g.now);
      for (const auto& p : taken(g.b)) other.receive(place(2), p.bytes, g.now);
    }
  }
  EXPECT_EQ(g.b.channels(), SecureChannels::kMostChannels);
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kFull), 50U);
  // After a minute they make room.
  g.now += 61'000'000;
  g.meet();
  EXPECT_EQ(g.b.channels(), SecureChannels::kMostChannels);
}

/// Somebody else whom `b` gets to know.
void meet_another(SecureChannels& b, std::uint64_t seed, Micros now) {
  SecureChannels other(channel_config(seed));
  other.send(place(2), kNoPeer, words("in"), now);
  for (int round = 0; round < 3; ++round) {
    for (const auto& p : taken(other)) b.receive(place(7), p.bytes, now);
    for (const auto& p : taken(b)) other.receive(place(2), p.bytes, now);
  }
}

// A coordinator may tell of any number of keys.
TEST(SecureChannels, WhoHasSpokenIsNotForgottenForThoseWhoNeverDid) {
  TwoPeers g;
  g.meet();
  const wire::Bytes recorded = g.sealed("once");
  ASSERT_TRUE(g.b.receive(place(1), recorded, g.now));
  for (std::uint64_t i = 0; i < 3 * SecureChannels::kMostChannels; ++i) {
    Endpoint told = place(9);
    told.key = wire::public_key(key_of(5000 + i));
    g.b.send(told, kNoPeer, words("you"), g.now + 1);
  }
  EXPECT_EQ(g.b.channels(), SecureChannels::kMostChannels);
  EXPECT_FALSE(g.b.receive(place(1), recorded, g.now));
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kReplay), 1U);
  EXPECT_TRUE(g.b.receive(place(1), g.sealed("again"), g.now));
}

TEST(SecureChannels, WhoHasLongBeenQuietMakesRoomForWhoWasJustToldOf) {
  TwoPeers g;
  for (std::uint64_t i = 0; i < SecureChannels::kMostChannels; ++i) meet_another(g.b, 9000 + i, g.now);
  g.now += 61'000'000;
  Endpoint gone = place(9);
  gone.key = wire::public_key(key_of(5000));
  Endpoint known = place(1);
  known.key = g.a.key();
  for (int i = 0; i < 5; ++i) {
    g.b.send(gone, kNoPeer, words("you"), g.now);
    g.b.send(known, kNoPeer, words("a member told of it"), g.now);
    g.say("here");
    g.carry();
    g.now += 20'000;
  }
  EXPECT_EQ(g.at_b.size(), 5U);
  const std::uint64_t handshakes = g.b.stats().handshakes;
  meet_another(g.b, 8000, g.now);
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kFull), 0U);
  EXPECT_GT(g.b.stats().handshakes, handshakes);
}

TEST(SecureChannels, WhatAForgottenPeerSaidDoesNotPassAgainWhenItIsBack) {
  TwoPeers g;
  g.meet();
  const wire::Bytes recorded = g.sealed("once");
  ASSERT_TRUE(g.b.receive(place(1), recorded, g.now));
  g.now += 61'000'000;
  for (std::uint64_t i = 0; i < SecureChannels::kMostChannels; ++i) meet_another(g.b, 9000 + i, g.now);
  EXPECT_EQ(g.b.channels(), SecureChannels::kMostChannels);
  EXPECT_FALSE(g.b.receive(place(1), recorded, g.now));
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kStranger), 1U) << "forgotten";
  g.b.send(g.names[0], kNoPeer, words("a member told of it"), g.now);
  EXPECT_FALSE(g.b.receive(place(1), recorded, g.now));
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kReplay), 1U);
  // It still has later keys than the first ones, and goes back to those after some introductions in vain.
  g.at_b.clear();
  for (int i = 0; i < 20; ++i) {
    g.now += 100'000;
    g.say("again");
    g.carry();
  }
  EXPECT_GT(g.at_b.size(), 5U);
  EXPECT_FALSE(g.b.receive(place(1), recorded, g.now));
}

// Anybody can say a Hello again that somebody else has said, and gets a cookie for it.
TEST(SecureChannels, NobodyIsForgottenForWhoProvesNothing) {
  int told = 0;
  node::ChannelConfig config = channel_config(2);
  config.on_key = [&](const PublicKey&, const PublicKey&, const wire::Key&) { ++told; };
  SecureChannels b(std::move(config));
  Micros now = 1'000'000;
  std::list<SecureChannels> others;
  for (std::uint64_t i = 0; i < SecureChannels::kMostChannels; ++i) {
    SecureChannels& other = others.emplace_back(channel_config(100 + i));
    other.send(place(2), kNoPeer, words("in"), now);
    for (int round = 0; round < 3; ++round) {
      for (const auto& p : taken(other)) b.receive(place(7), p.bytes, now);
      for (const auto& p : taken(b)) other.receive(place(2), p.bytes, now);
    }
  }
  ASSERT_EQ(b.channels(), SecureChannels::kMostChannels);
  EXPECT_EQ(told, 4 * static_cast<int>(SecureChannels::kMostChannels)) << "the first keys and new ones";
  now += 61'000'000;
  const PublicKey stranger = wire::public_key(key_of(5));
  const wire::Key h = wire::handshake_key(channel_config(1).session);
  b.receive(place(66), wire::encode_handshake(wire::Hello{stranger, 1}, h), now);
  const auto answer = wire::decode_handshake(taken(b).at(0).bytes, h);
  ASSERT_TRUE(answer && std::holds_alternative<wire::Cookie>(*answer));
  const wire::Introduction in{stranger, 1, std::get<wire::Cookie>(*answer).cookie};
  b.receive(place(66), wire::encode_handshake(in, key_of(9)), now);
  EXPECT_EQ(b.stats().dropped[static_cast<std::size_t>(ChannelDrop::kTag)], 1U);
  EXPECT_EQ(b.channels(), SecureChannels::kMostChannels);
  EXPECT_EQ(told, 4 * static_cast<int>(SecureChannels::kMostChannels)) << "its keys have been told";
  SecureChannels& quietest = others.front();
  Endpoint name = place(2);
  name.key = b.key();
  quietest.send(name, kNoPeer, words("still here"), now);
  bool passes = false;
  for (const auto& p : taken(quietest)) passes = passes || b.receive(place(7), p.bytes, now).has_value();
  EXPECT_TRUE(passes);
}

TEST(SecureChannels, PlacesThatNeverAnswerAreForgotten) {
  TwoPeers g;
  for (int n = 3; n < 100; ++n) {
    g.a.send(place(n), kNoPeer, words("is anybody there"), g.now);
    EXPECT_LE(g.a.callers(), SecureChannels::kMostWaiting);
    taken(g.a);
  }
  EXPECT_EQ(g.a.callers(), SecureChannels::kMostWaiting);
}

}  // namespace
}  // namespace padr::test
