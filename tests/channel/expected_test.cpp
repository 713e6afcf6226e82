// Somebody of whom another peer has told: where it is, and its key.
#include "tests/channel/two_peers.h"

namespace padr::test {
namespace {

using node::ChannelDrop;
using node::SecureChannels;

Endpoint named(const SecureChannels& peer, int n) {
  Endpoint e = place(n);
  e.key = peer.key();
  return e;
}

// No more than three times what the word about it was long, with its headers.
TEST(Expected, GetsThreeHellosAtMost) {
  TwoPeers g;
  const Micros since = g.now;
  std::vector<Micros> at;
  for (; g.now < since + 3 * kMicrosPerSecond; g.now += 10'000) {
    g.b.expect(named(g.a, 1), since, g.now);
    for (const auto& p : taken(g.b)) {
      EXPECT_EQ(p.to, place(1));
      EXPECT_TRUE(wire::is_handshake(p.bytes));
      at.push_back(g.now - since);
    }
  }
  EXPECT_EQ(at, (std::vector<Micros>{0, 300'000, 600'000}));
}

TEST(Expected, IsOpenedWithoutAHandshake) {
  TwoPeers g;
  g.b.expect(named(g.a, 1), g.now, g.now);
  taken(g.b);
  g.a.send(named(g.b, 2), kNoPeer, words("first"), g.now);
  for (const auto& p : taken(g.a)) g.take(g.b, g.at_b, place(1), p.bytes);
  EXPECT_EQ(g.at_b, std::vector<wire::Bytes>{words("first")});
  EXPECT_EQ(g.dropped_at_b(ChannelDrop::kStranger), 0U);
}

TEST(Expected, OnlyAnEchoShowsThatBothWaysWork) {
  TwoPeers g;
  g.b.expect(named(g.a, 1), g.now, g.now);
  taken(g.b);  // lost
  g.a.send(named(g.b, 2), kNoPeer, words("first"), g.now);
  const auto sent = taken(g.a);
  for (const auto& p : sent)
    if (wire::read_sealed(p.bytes)) g.take(g.b, g.at_b, place(1), p.bytes);
  EXPECT_EQ(g.at_b.size(), 1U);
  EXPECT_FALSE(g.b.came(g.a.key(), g.now).directly);
  for (const auto& p : sent)
    if (wire::is_handshake(p.bytes)) g.take(g.b, g.at_b, place(1), p.bytes);
  g.carry();
  EXPECT_TRUE(g.b.came(g.a.key(), g.now).directly);
  EXPECT_TRUE(g.a.came(g.b.key(), g.now).directly);
  EXPECT_FALSE(g.a.came(g.b.key(), g.now).carried);
  EXPECT_FALSE(g.a.came(g.b.key(), g.now + 2'000'001).directly);
  EXPECT_FALSE(g.a.came(key_of(5), g.now).directly) << "a stranger";
}

/// a to b, who answers in between.
void say_twice(TwoPeers& g) {
  for (const char* text : {"first", "second"}) {
    g.a.send(named(g.b, 2), kNoPeer, words(text), g.now);
    g.carry();
  }
}

// The member that has told of it may see it on their LAN.
TEST(Expected, HasTheNameOfThePlaceFromWhichItAnswers) {
  TwoPeers g;
  g.b.expect(named(g.a, 9), g.now, g.now);
  taken(g.b);
  say_twice(g);
  ASSERT_EQ(g.names.size(), 2U);
  EXPECT_EQ(g.names[0], named(g.a, 9)) << "nothing is proven yet";
  EXPECT_EQ(g.names[1], named(g.a, 1));
}

TEST(Expected, HasTheNameThatAllKnowOnceItIsAMember) {
  TwoPeers g;
  g.b.expect(named(g.a, 9), g.now, g.now);
  g.b.send(named(g.a, 9), 3, words("state"), g.now);
  taken(g.b);
  say_twice(g);
  ASSERT_EQ(g.names.size(), 2U);
  EXPECT_EQ(g.names[1], named(g.a, 9));
}

}  // namespace
}  // namespace padr::test
