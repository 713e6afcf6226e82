#include <gtest/gtest.h>

#include <algorithm>

#include "tests/seed.h"
#include "tests/session/virtual_net.h"

namespace padr::test {
namespace {

using node::SessionPhase;

node::SessionConfig founder(std::uint64_t seed, int wanted) {
  node::SessionConfig c = alike(seed);
  c.wanted = c.slots = wanted;
  return c;
}
node::SessionConfig joiner(std::uint64_t seed, int member) {
  node::SessionConfig c = alike(seed);
  c.join = place(member);
  return c;
}

/// A founder at place 1 and joiners at 2 .. n, all through the founder, have started.
bool start_all(VirtualNet& net, std::uint64_t seed, int peers, Micros within) {
  net.add(1, founder(seed, peers));
  for (int n = 2; n <= peers; ++n) net.add(n, joiner(seed + static_cast<std::uint64_t>(n), 1));
  return net.run(within, [&] { return net.all(SessionPhase::kStarted); });
}

bool knows(const node::Session& s, const Endpoint& where) {
  return std::find(s.beginners().begin(), s.beginners().end(), where) != s.beginners().end();
}

/// Everybody knows everybody, by the same numbers and at the right places.
void expect_mesh(VirtualNet& net, int peers) {
  std::set<PeerId> numbers;
  for (int n = 1; n <= peers; ++n) {
    node::Session& s = net.at(n);
    numbers.insert(s.self());
    EXPECT_EQ(s.number(), net.at(1).number());
    EXPECT_NE(s.number(), 0);
    EXPECT_EQ(s.slots(), peers);
    ASSERT_EQ(s.beginners().size(), static_cast<std::size_t>(peers));
    for (int m = 1; m <= peers; ++m) {
      if (m == n) continue;
      EXPECT_EQ(s.beginners()[net.at(m).self()], place(m)) << n << " of " << m;
    }
    EXPECT_FALSE(knows(s, place(99)));
  }
  EXPECT_EQ(numbers.size(), static_cast<std::size_t>(peers));
  EXPECT_EQ(*numbers.rbegin(), peers - 1) << "numbers have no gaps";
}

/// Largest difference between two session clocks, us.
Micros spread(VirtualNet& net, int peers) {
  Micros lo = net.at(1).session_now(net.local(1));
  Micros hi = lo;
  for (int n = 2; n <= peers; ++n) {
    const Micros t = net.at(n).session_now(net.local(n));
    lo = std::min(lo, t);
    hi = std::max(hi, t);
  }
  return hi - lo;
}

TEST(Handshake, OnePeerAloneStartsAtOnce) {
  VirtualNet net(1);
  net.add(1, founder(1, 1));
  EXPECT_EQ(net.at(1).phase(), SessionPhase::kStarted);
  EXPECT_EQ(net.at(1).self(), 0);
  EXPECT_EQ(net.at(1).session_now(net.local(1)), 0);
}

TEST(Handshake, TwoPeersOnAPerfectLink) {
  VirtualNet net(1);
  ASSERT_TRUE(start_all(net, 1, 2, 2'000'000)) << net.story();
  expect_mesh(net, 2);
  EXPECT_LE(spread(net, 2), 2 * VirtualNet::kStep);
  EXPECT_LT(net.at(2).session_now(net.local(2)), -400'000) << "everybody knows well before tick 0";
}

TEST(Handshake, SixtyFourPeersOverABadNetwork) {
  const std::uint64_t seed = 7;
  VirtualNet net(seed, "delay 60ms 30ms loss 10%");
  ASSERT_TRUE(start_all(net, seed, 64, 20'000'000)) << net.story();
  expect_mesh(net, 64);
}

TEST(Handshake, LossDuplicatesReorderingAndCorruption) {
  const std::uint64_t first = seed(1);
  for (std::uint64_t seed = first; seed < first + 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    VirtualNet net(seed, "delay 100ms 50ms loss 30% duplicate 10% reorder 5% corrupt 1%");
    ASSERT_TRUE(start_all(net, seed, 4, 25'000'000)) << net.story();
    expect_mesh(net, 4);
    // The last to hear of it may be late, but never so late that the others have given up on it.
    EXPECT_LT(net.at(1).session_now(net.local(1)), 1'000'000);
  }
}

// Jitter of one way only, and as much of it as there is: the least delays are alike, so the clocks are too.
TEST(Handshake, ClocksAgreeWithinATickUnderAsymmetricJitter) {
  const std::uint64_t first = seed(1);
  for (std::uint64_t seed = first; seed < first + 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    VirtualNet net(seed, "delay 120ms 100ms loss 30% duplicate 10%");
    for (int n = 2; n <= 4; ++n) net.set_link(1, n, "delay 25ms 5ms loss 30%");
    ASSERT_TRUE(start_all(net, seed, 4, 25'000'000)) << net.story();
    net.run(6'000'000);
    EXPECT_LE(spread(net, 4), kMicrosPerSecond / kTicksPerSecond) << net.story();
  }
}

TEST(Handshake, RepeatsAreBounded) {
  VirtualNet net(1);
  net.add(2, joiner(2, 1));  // nobody is there
  net.run(10'000'000);
  EXPECT_LE(net.sent(place(2), place(1)), 10U * 6U);
  EXPECT_GE(net.sent(place(2), place(1)), 10U * 3U);
}

TEST(Handshake, MeshIsLearnedThroughAnyMember) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    VirtualNet net(seed, "delay 30ms 10ms loss 20%");
    net.add(1, founder(seed, 4));
    net.add(2, joiner(seed + 2, 1));
    net.add(3, joiner(seed + 3, 2));
    net.add(4, joiner(seed + 4, 3));  // through one that is not in yet itself
    ASSERT_TRUE(net.run(20'000'000, [&] { return net.all(SessionPhase::kStarted); })) << net.story();
    expect_mesh(net, 4);
    EXPECT_TRUE(net.noted(3, "passes us on")) << net.story();
  }
}

TEST(Handshake, BarrierHoldsUntilTheLastIsThere) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(8'000'000);
  EXPECT_TRUE(net.all(SessionPhase::kGathering));
  EXPECT_EQ(net.at(1).present(), 2);
  EXPECT_EQ(net.at(2).present(), 2);
  net.add(3, joiner(3, 1));
  EXPECT_TRUE(net.run(2'000'000, [&] { return net.all(SessionPhase::kStarted); })) << net.story();
}

TEST(Handshake, OneThatLeftBeforeTheStartMakesRoom) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(1'000'000);
  net.at(2).leave();
  net.run(100'000);
  net.remove(2);
  EXPECT_TRUE(net.noted(1, "left before the start")) << net.story();
  net.add(3, joiner(3, 1));
  net.add(4, joiner(4, 1));
  ASSERT_TRUE(net.run(2'000'000, [&] { return net.all(SessionPhase::kStarted); })) << net.story();
  EXPECT_FALSE(knows(net.at(1), place(2)));
}

TEST(Handshake, OneThatVanishedBeforeTheStartMakesRoom) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(1'000'000);
  net.remove(2);
  net.run(4'000'000);
  EXPECT_EQ(net.at(1).present(), 2) << "4 s of silence are not enough";
  net.run(2'000'000);
  EXPECT_EQ(net.at(1).present(), 1);
  EXPECT_TRUE(net.noted(1, "silent before the start"));
}

TEST(Handshake, AProgramStartedAnewAtTheSameAddressTakesItsOldPlace) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(1'000'000);
  net.add(2, joiner(77, 1));
  net.run(1'000'000);
  EXPECT_EQ(net.at(2).phase(), SessionPhase::kGathering) << net.story();
  EXPECT_EQ(net.at(2).self(), 1);
  net.add(3, joiner(3, 1));
  EXPECT_TRUE(net.run(2'000'000, [&] { return net.all(SessionPhase::kStarted); })) << net.story();
}

TEST(Handshake, TimeoutsSayWhy) {
  VirtualNet net(1);
  node::SessionConfig alone = founder(1, 3);
  alone.patience = 4'000'000;
  net.add(1, alone);
  node::SessionConfig patient = joiner(2, 1);
  net.add(2, patient);
  node::SessionConfig lost = joiner(3, 50);
  lost.patience = 2'000'000;
  net.add(3, lost);
  net.run(1'990'000);
  EXPECT_EQ(net.at(3).phase(), SessionPhase::kJoining);
  net.run(30'000);
  EXPECT_EQ(net.at(3).failure(), "no answer from 10.0.0.50:7000 within 2 s");
  net.run(2'100'000);
  EXPECT_EQ(net.at(1).failure(), "only 2 of 3 peers came within 4 s");
  EXPECT_NE(net.at(2).failure().find("has ended the session before its start: only 2 of 3"), std::string::npos)
      << net.at(2).failure();
}

TEST(Handshake, AFounderThatVanishesIsNoticed) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(1'000'000);
  net.remove(1);
  net.run(6'000'000);
  EXPECT_NE(net.at(2).failure().find("silent for 5 s"), std::string::npos) << net.story();
}

TEST(Handshake, JoiningOneselfIsNoticed) {
  VirtualNet net(1);
  net.add(1, joiner(1, 1));
  net.run(500'000);
  EXPECT_NE(net.at(1).failure().find("is this peer itself"), std::string::npos) << net.story();
}

// It crashed and comes back through a member that has not missed it yet.
TEST(Handshake, AFounderThatIsPassedOnToItselfAsksAgain) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(1'000'000);
  net.add(1, joiner(77, 2));
  net.run(3'000'000);
  EXPECT_TRUE(net.noted(1, "passes us on to the founder at " + to_string(place(1)))) << net.story();
  EXPECT_EQ(net.at(1).phase(), SessionPhase::kJoining) << net.story();
  const auto asked = net.sent(place(1), place(2));
  net.run(1'000'000);
  EXPECT_GT(net.sent(place(1), place(2)), asked) << net.story();
}

// The founder plays on one machine with others and tells of them by loopback addresses.
TEST(Handshake, ALoopbackAddressToldByAnotherMachineMeansThatMachine) {
  VirtualNet net(1);
  net.add(1, founder(1, 3));
  net.add(2, joiner(2, 1));
  net.run(1'000'000);
  ASSERT_EQ(net.at(2).phase(), SessionPhase::kGathering);
  Endpoint neighbour = place(0);
  neighbour.address = Endpoint{}.address;
  neighbour.address[15] = 1;
  neighbour.port = 7009;
  const auto start = wire::encode_session(wire::Start{net.local(1) + 1'000'000, {Endpoint{}, place(2), neighbour}});
  net.inject(place(1), 2, wire::seal({wire::Kind::kSession, 0, net.at(1).number()}, start));
  ASSERT_EQ(net.at(2).phase(), SessionPhase::kStarted);
  Endpoint there = place(1);
  there.port = 7009;
  EXPECT_EQ(net.at(2).beginners()[2], there);
}

}  // namespace
}  // namespace padr::test
