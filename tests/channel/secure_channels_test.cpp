#include "common/channel/secure_channels.h"

#include <algorithm>
#include <list>

#include "tests/channel/two_peers.h"

namespace padr::test {
namespace {

using node::ChannelDrop;
using node::SecureChannels;

TEST(SecureChannels, WhoKnowsOnlyAPlaceGetsThroughAfterOneHandshake) {
  TwoPeers g;
  g.say("first");
  g.say("second");  // only the last is kept, and nobody is greeted twice at once
  auto out = taken(g.a);
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].to, place(2));
  g.take(g.b, g.at_b, place(1), out[0].bytes);
  g.carry();
  EXPECT_EQ(g.at_b, std::vector<wire::Bytes>{words("second")});
  ASSERT_EQ(g.names.size(), 1U);
  EXPECT_TRUE(same_place(g.names[0], place(1)));
  EXPECT_EQ(g.names[0].key, g.a.key());
  g.b.send(g.names[0], kNoPeer, words("back"), g.now);
  g.carry();
  EXPECT_EQ(g.at_a, std::vector<wire::Bytes>{words("back")});
  EXPECT_EQ(g.names[1].key, g.b.key());
}

// All programs that forget it would have one secret key, which everybody knows.
TEST(SecureChannels, ASeedThatWasForgottenIsNoSeed) {
  node::ChannelConfig c = channel_config(1);
  c.seed = {};
  EXPECT_DEATH(SecureChannels{c}, "seed");
}

TEST(SecureChannels, WhoIsToldOfAKeyNeedsNoHandshakeIfTheOtherIsToldToo) {
  TwoPeers g;
  Endpoint to_b = place(2);
  to_b.key = g.b.key();
  Endpoint to_a = place(1);
  to_a.key = g.a.key();
  g.a.send(to_b, 1, words("a"), g.now);
  g.b.send(to_a, 0, words("b"), g.now);
  g.carry();
  EXPECT_EQ(g.at_a, std::vector<wire::Bytes>{words("b")});
  EXPECT_EQ(g.at_b, std::vector<wire::Bytes>{words("a")});
  g.a.send(to_b, 1, words("c"), g.now);
  const auto out = taken(g.a);
  ASSERT_EQ(out.size(), 1U) << "nothing but the datagram once they have met";
  EXPECT_EQ(out[0].state_to, 1);
}

TEST(SecureChannels, WhoIsToldAloneIntroducesItself) {
  TwoPeers g;
  Endpoint to_b = place(2);
  to_b.key = g.b.key();
  g.a.send(to_b, 1, words("lost"), g.now);
  g.carry();
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kStranger), 1U);
  g.a.send(to_b, 1, words("heard"), g.now);
  g.carry();
  EXPECT_EQ(g.at_b, std::vector<wire::Bytes>{words("heard")});
}

TEST(SecureChannels, AnotherSessionsKeyOpensNothing) {
  TwoPeers g;
  SecureChannels other(channel_config(3, wire::SealMode::kAuth, 2));
  other.send(place(2), kNoPeer, words("let me in"), g.now);
  for (const auto& p : taken(other)) EXPECT_FALSE(g.b.receive(place(3), p.bytes, g.now));
  EXPECT_TRUE(taken(g.b).empty()) << "no answer either";
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kTag), 1U);
}

TEST(SecureChannels, WhatIsNotSealedIsNotRead) {
  TwoPeers g;
  g.meet();
  EXPECT_FALSE(g.b.receive(place(1), words("plain"), g.now));
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kUnsealed), 1U);
  EXPECT_FALSE(g.b.receive(place(1), wire::Bytes(50), g.now));
  EXPECT_FALSE(g.b.receive(place(1), wire::Bytes{}, g.now));
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kForm), 2U);
  EXPECT_TRUE(taken(g.b).empty());
}

TEST(SecureChannels, WhoEncryptsIsToldOnceOfEachPeerThatDoesNot) {
  TwoPeers g(wire::SealMode::kAuth, wire::SealMode::kEncrypt);
  g.meet();
  g.say("again");
  g.carry();
  EXPECT_EQ(g.b.stats().readable, 2U);
  ASSERT_EQ(g.b.take_readable().size(), 1U);
  EXPECT_TRUE(g.b.take_readable().empty());
  g.b.send(place(1), kNoPeer, words("hidden"), g.now);
  g.carry();
  EXPECT_EQ(g.a.stats().readable, 0U);
  EXPECT_TRUE(g.a.take_readable().empty());
}

TEST(SecureChannels, ADatagramPassesOnce) {
  TwoPeers g;
  g.meet();
  const wire::Bytes d = g.sealed("once");
  EXPECT_TRUE(g.b.receive(place(1), d, g.now));
  EXPECT_FALSE(g.b.receive(place(1), d, g.now));
  EXPECT_FALSE(g.b.receive(place(9), d, g.now)) << "from elsewhere";
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kReplay), 2U);
  EXPECT_FALSE(g.a.receive(place(2), d, g.now)) << "sent back to its sender";
}

TEST(SecureChannels, LateOnesPassAsFarAsTheWindowReaches) {
  TwoPeers g;
  g.meet();
  std::vector<wire::Bytes> d;
  for (int i = 0; i < 4097; ++i) d.push_back(g.sealed("x"));
  EXPECT_TRUE(g.b.receive(place(1), d[4096], g.now));
  EXPECT_TRUE(g.b.receive(place(1), d[1], g.now)) << "4095 behind";
  EXPECT_FALSE(g.b.receive(place(1), d[0], g.now)) << "4096 behind";
}

TEST(SecureChannels, AThirdMemberCannotSpeakForAnother) {
  TwoPeers g;
  g.meet();
  // It has the session's key and knows all public keys, but not the secret one.
  node::ChannelConfig c = channel_config(3);
  SecureChannels third(c);
  const auto keys = wire::pair_keys(c.session, wire::derive_key(c.seed, "secret"), g.a.key(), g.b.key());
  ASSERT_TRUE(keys);
  const wire::Bytes forged =
      wire::seal_with(keys->out, wire::SealMode::kAuth, wire::short_id(g.a.key()), 1000, words("forged"));
  EXPECT_FALSE(g.b.receive(place(1), forged, g.now));
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kTag), 1U);
  // Nor can it introduce itself with another's key, though it can get a cookie for it.
  third.receive(place(2), wire::Bytes{}, g.now);
  const wire::Key h = wire::handshake_key(c.session);
  g.b.receive(place(3), wire::encode_handshake(wire::Hello{g.a.key(), 5}, h), g.now);
  const auto out = taken(g.b);
  ASSERT_EQ(out.size(), 1U);
  const auto cookie = std::get<wire::Cookie>(*wire::decode_handshake(out[0].bytes, h));
  g.b.receive(place(3), wire::encode_handshake(wire::Introduction{g.a.key(), 2000, cookie.cookie}, keys->out), g.now);
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kTag), 2U);
  EXPECT_TRUE(g.b.receive(place(1), g.sealed("still there"), g.now));
}

TEST(SecureChannels, ACookieIsForOneAddressAndSomeSeconds) {
  TwoPeers g;
  const wire::Key h = wire::handshake_key(channel_config(1).session);
  const auto introduction_from = [&](const Endpoint& from, Micros later) {
    TwoPeers fresh;
    fresh.b.receive(place(1), wire::encode_handshake(wire::Hello{fresh.a.key(), 5}, h), fresh.now);
    const auto cookie = std::get<wire::Cookie>(*wire::decode_handshake(taken(fresh.b)[0].bytes, h));
    const auto keys = wire::pair_keys(channel_config(1).session, wire::derive_key(channel_config(1).seed, "secret"),
                                      fresh.a.key(), fresh.b.key());
    fresh.b.receive(from, wire::encode_handshake(wire::Introduction{fresh.a.key(), 1, cookie.cookie}, keys->out),
                    fresh.now + later);
    return taken(fresh.b).size() == 1 && fresh.b.channels() == 1;
  };
  EXPECT_TRUE(introduction_from(place(1), 0));
  EXPECT_FALSE(introduction_from(place(4), 0));
  EXPECT_TRUE(introduction_from(place(1), 9'000'000));
  EXPECT_FALSE(introduction_from(place(1), 20'000'000));
}

TEST(SecureChannels, AnIntroductionPassesOnce) {
  TwoPeers g;
  g.say("hello");
  g.take(g.b, g.at_b, place(1), taken(g.a)[0].bytes);
  const auto cookie = taken(g.b);
  g.a.receive(place(2), cookie[0].bytes, g.now);
  const auto out = taken(g.a);
  ASSERT_EQ(out.size(), 2U) << "introduction and what waited";
  g.b.receive(place(1), out[0].bytes, g.now);
  EXPECT_EQ(taken(g.b).size(), 1U);
  g.b.receive(place(1), out[0].bytes, g.now);
  EXPECT_EQ(taken(g.b).size(), 0U);
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kReplay), 1U);
}

/// `a`, which seems to have moved there, answers what `b` asks it.
void answer_from(TwoPeers& g, const Endpoint& there) {
  for (const auto& p : taken(g.b))
    if (same_place(p.to, there)) g.a.receive(place(2), p.bytes, g.now);
  for (const auto& p : taken(g.a)) g.b.receive(there, p.bytes, g.now);
  taken(g.b);
}

// Whoever has recorded a datagram can send it first, in the name of a third machine.
TEST(SecureChannels, WhereSomebodySeemsToHaveMovedLittleIsSentUntilItAnswers) {
  TwoPeers g;
  g.meet();
  const Endpoint victim = place(66);
  std::size_t in = 0;
  std::size_t out = 0;
  std::size_t home = 0;
  for (int i = 0; i < 200; ++i) {
    const wire::Bytes recorded = g.sealed("x");
    in += recorded.size();
    ASSERT_TRUE(g.b.receive(victim, recorded, g.now));
    for (int k = 0; k < 64; ++k) g.b.send(g.names[0], kNoPeer, words(std::string(1000, 'x')), g.now);
    for (const auto& p : taken(g.b)) {
      (same_place(p.to, victim) ? out : home) += p.bytes.size();
      if (!same_place(p.to, victim)) g.a.receive(place(2), p.bytes, g.now);
    }
    g.now += 16'667;
  }
  EXPECT_GT(out, 0U) << "it is asked";
  EXPECT_LE(out, SecureChannels::kUnprovenTimes * in);
  EXPECT_GT(home, 200U * 64 * 1000) << "nothing is lost to who has not moved";
}

TEST(SecureChannels, WhoMovesKeepsItsName) {
  TwoPeers g;
  g.meet();
  const Endpoint name = g.names[0];
  const wire::Bytes early = g.sealed("early");
  const auto moved = g.b.receive(place(5), g.sealed("from elsewhere"), g.now);
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->from, name);
  EXPECT_EQ(g.b.stats().moves, 1U);
  answer_from(g, place(5));
  g.b.send(name, kNoPeer, words("to you"), g.now);
  EXPECT_EQ(taken(g.b).at(0).to, place(5));
  // What was under way before does not move it back.
  EXPECT_TRUE(g.b.receive(place(1), early, g.now));
  g.b.send(name, kNoPeer, words("to you"), g.now);
  EXPECT_EQ(taken(g.b).at(0).to, place(5));
}

// Found by fuzzing: who passes on one datagram of each from elsewhere, before it arrives, has both send there for ever.
TEST(SecureChannels, BothLedAstrayAtOnceFindOneAnotherAgain) {
  TwoPeers g;
  g.meet();
  g.b.send(g.names[0], kNoPeer, words("back"), g.now);
  const wire::Bytes forth = g.sealed("forth");
  const wire::Bytes back = taken(g.b).at(0).bytes;
  ASSERT_TRUE(g.b.receive(place(5), forth, g.now));
  ASSERT_TRUE(g.a.receive(place(5), back, g.now));
  taken(g.b);  // what they ask at place 5
  g.say("where are you");
  bool arrived = false;
  for (const auto& p : taken(g.a))
    if (same_place(p.to, place(2))) arrived = arrived || g.b.receive(place(1), p.bytes, g.now);
  EXPECT_TRUE(arrived);
  g.b.send(g.names[0], kNoPeer, words("here"), g.now);
  EXPECT_EQ(taken(g.b).at(0).to, place(1));
}

TEST(SecureChannels, WhoIsLedAstrayForLongIsLookedForWhereItWasToldToBe) {
  TwoPeers g;
  g.meet();
  ASSERT_TRUE(g.b.receive(place(5), g.sealed("x"), g.now));
  answer_from(g, place(5));
  for (int i = 0; i < SecureChannels::kSettled; ++i) ASSERT_TRUE(g.b.receive(place(5), g.sealed("x"), g.now));
  const auto is_sent_home = [&] {
    g.b.send(g.names[0], kNoPeer, words("to you"), g.now);
    const auto out = taken(g.b);
    return std::any_of(out.begin(), out.end(), [](const auto& p) { return same_place(p.to, place(1)); });
  };
  g.now += 2'000'000;
  EXPECT_FALSE(is_sent_home());
  g.now += 1;
  EXPECT_TRUE(is_sent_home());
}

TEST(SecureChannels, WhoHasMovedIsSentToWhereItWasUntilItIsSettled) {
  TwoPeers g;
  g.meet();
  const Endpoint name = g.names[0];
  const auto places = [&] {
    g.b.send(name, kNoPeer, words("to you"), g.now);
    std::vector<Endpoint> to;
    for (const auto& p : taken(g.b)) to.push_back(p.to);
    return to;
  };
  ASSERT_TRUE(g.b.receive(place(5), g.sealed("x"), g.now));
  answer_from(g, place(5));  // which sends something itself
  for (int i = 0; i < SecureChannels::kSettled; ++i) {
    EXPECT_EQ(places(), (std::vector{place(5), place(1)})) << i;
    ASSERT_TRUE(g.b.receive(place(5), g.sealed("x"), g.now));
  }
  EXPECT_EQ(places(), std::vector{place(5)});
}

TEST(SecureChannels, ForgedDatagramsDoNotMoveAnybody) {
  TwoPeers g;
  g.meet();
  wire::Bytes d = g.sealed("x");
  d.back() ^= std::byte{1};
  EXPECT_FALSE(g.b.receive(place(5), d, g.now));
  g.b.send(g.names[0], kNoPeer, words("to you"), g.now);
  EXPECT_EQ(taken(g.b).at(0).to, place(1));
}

TEST(SecureChannels, KeysAreToldOfSoManyPeersAtMost) {
  int told = 0;
  node::ChannelConfig config = channel_config(1);
  config.on_key = [&](const PublicKey&, const PublicKey&, const wire::Key&) { ++told; };
  config.most_keys = 3;
  SecureChannels a(std::move(config));
  for (std::uint64_t n = 1; n <= 5; ++n) {
    Endpoint to = place(static_cast<int>(n));
    to.key = wire::public_key(key_of(50 + n));
    a.send(to, 1, words("x"), 0);
    EXPECT_EQ(told, 2 * static_cast<int>(std::min<std::uint64_t>(n, 3)));
    EXPECT_EQ(a.has_told_all_keys(), n >= 3);
  }
}

TEST(SecureChannels, KeysAreToldOncePerDirection) {
  std::vector<std::pair<PublicKey, PublicKey>> told;
  node::ChannelConfig c = channel_config(1);
  c.on_key = [&](const PublicKey& from, const PublicKey& to, const wire::Key&) { told.emplace_back(from, to); };
  SecureChannels a(c);
  Endpoint b = place(2);
  b.key = wire::public_key(key_of(50));
  a.send(b, 1, words("x"), 0);
  a.send(b, 1, words("y"), 0);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0], (std::pair{a.key(), b.key}));
  EXPECT_EQ(told[1], (std::pair{b.key, a.key()}));
}

TEST(SecureChannels, DamagedDatagramsNeverPassNorCrash) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  TwoPeers g;
  g.meet();
  std::vector<wire::Bytes> genuine{g.sealed("one"), g.sealed("two")};
  const wire::Key h = wire::handshake_key(channel_config(1).session);
  genuine.push_back(wire::encode_handshake(wire::Hello{g.a.key(), 9}, h));
  genuine.push_back(wire::encode_handshake(wire::Introduction{g.a.key(), 9, {}}, h));
  for (int i = 0; i < 200'000; ++i) {
    wire::Bytes d = genuine[rng.below(static_cast<std::uint32_t>(genuine.size()))];
    const std::uint32_t flips = 1 + rng.below(4);
    for (std::uint32_t f = 0; f < flips; ++f)
      d[rng.below(static_cast<std::uint32_t>(d.size()))] ^= static_cast<std::byte>(1 + rng.below(255));
    if (rng.chance(0.1)) d.resize(rng.below(1300));
    bool changed = true;
    for (const wire::Bytes& was : genuine) changed = changed && d != was;
    if (changed) {
      ASSERT_FALSE(g.b.receive(place(static_cast<int>(rng.below(5))), d, g.now));
    }
  }
  EXPECT_TRUE(g.b.receive(place(1), genuine[0], g.now));
}

}  // namespace
}  // namespace padr::test
