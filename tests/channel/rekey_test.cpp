// New keys as time goes on: through a bad network, after pauses and partitions, and what an attacker gets out of them.
#include <gtest/gtest.h>

#include <map>

#include "tests/channel/talk.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

using node::ChannelDrop;
using node::ChannelKeys;
using node::SecureChannels;

constexpr int kRekey = 5;

TEST(Rekey, NewKeysComeAtOnceAndThenEveryTwoMinutes) {
  Talk t(1);
  t.run(1);
  EXPECT_EQ(t.rekeys(0), 1U);
  EXPECT_EQ(t.rekeys(1), 1U);
  t.run(118);
  EXPECT_EQ(t.rekeys(0), 1U);
  t.run(3);
  EXPECT_EQ(t.rekeys(0), 2U);
  EXPECT_EQ(t.rekeys(1), 2U);
  t.run(600);
  EXPECT_EQ(t.rekeys(0), 7U);
  EXPECT_EQ(t.rekeys(1), 7U);
  EXPECT_EQ(t.dropped(0, ChannelDrop::kTag) + t.dropped(1, ChannelDrop::kTag), 0U);
  EXPECT_EQ(t.told[0].size(), 2U * 8);
  for (std::size_t n : {0U, 1U}) EXPECT_GT(t.share_heard(n), 0.999);
}

class RekeySeeds : public testing::TestWithParam<std::uint64_t> {};

TEST_P(RekeySeeds, SurvivesLossReorderingDuplicatesAndDamage) {
  const std::uint64_t seed = test::seed(GetParam());
  Talk t(seed);
  t.network = {.loss = 0.3, .twice = 0.2, .damage = 0.05, .delay = 50'000, .jitter = 300'000};
  t.run(600);
  for (std::size_t n : {0U, 1U}) {
    EXPECT_GE(t.rekeys(n), 4U);
    EXPECT_LE(t.rekeys(n), 6U);
    EXPECT_GT(t.share_heard(n), 0.655) << "of 0.7 x 0.95";
  }
  EXPECT_EQ(t.heard_twice, 0U);
}

TEST_P(RekeySeeds, NobodyIsDeafForLongWhateverHappens) {
  const std::uint64_t seed = test::seed(GetParam());
  Talk t(seed);
  Rng rng(seed);
  for (int i = 0; i < 100; ++i) {
    t.network = {.loss = 0.6 * rng.uniform(), .twice = 0.3, .damage = 0.1, .delay = 20'000, .jitter = 400'000};
    const std::uint32_t what = rng.below(5);
    const std::size_t n = rng.below(2);
    if (what == 0) t.still[n] = true;
    if (what == 1) t.silent[n] = true;
    if (what == 2) t.lets_through = [](std::size_t, const wire::Bytes&) { return false; };
    if (what == 3) t.lets_through = [n](std::size_t from, const wire::Bytes&) { return from != n; };
    if (what == 4) t.at[n].port = static_cast<std::uint16_t>(1000 + rng.below(1000));
    t.run(rng.chance(0.2) ? 150 : 8);
    t.still = t.silent = {};
    t.lets_through = nullptr;
    t.network = {};
    t.run(4);
    t.mark();
    t.run(1);
    for (const std::size_t k : {0U, 1U})
      ASSERT_GT(t.share_heard(k), 0.9) << "case " << what << " of " << n << ", " << i;
  }
  EXPECT_EQ(t.heard_twice, 0U);
  EXPECT_GT(t.rekeys(0), 10U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RekeySeeds, testing::Range<std::uint64_t>(1, 6));

TEST(Rekey, BothMayBeginAtOnce) {
  Talk t(2);
  int begun = 0;
  t.lets_through = [&](std::size_t, const wire::Bytes& d) {
    constexpr std::size_t kHas = 52;
    const bool knows_nothing = is_message(d, kRekey) && std::all_of(d.begin() + kHas, d.begin() + kHas + 8,
                                                                    [](std::byte b) { return b == std::byte{}; });
    begun += knows_nothing ? 1 : 0;
    return true;
  };
  t.run(1);
  EXPECT_EQ(begun, 2);
  EXPECT_EQ(t.rekeys(0), 1U);
  EXPECT_EQ(t.rekeys(1), 1U);
  EXPECT_EQ(t.told[0].size(), 4U) << "the first keys and one new pair";
  EXPECT_GT(t.share_heard(0), 0.95);
}

// At whatever moments the two get to know one another, nothing that arrives is refused for its key.
TEST(Rekey, WhileTwoMeetNothingIsLost) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Talk t(seed);
    Rng rng(seed);
    t.network.delay = rng.below(120'000);
    t.network.jitter = rng.chance(0.5) ? rng.below(60'000) : 0;
    t.network.loss = rng.chance(0.5) ? 0.1 : 0;
    t.silent[0] = rng.chance(0.5);
    t.run(0.2 * rng.uniform());
    t.silent[0] = false;
    t.run(2);
    ASSERT_EQ(t.dropped(0, ChannelDrop::kTag) + t.dropped(1, ChannelDrop::kTag), 0U) << "seed " << seed;
    t.mark();
    t.run(1);
    for (const std::size_t n : {0U, 1U}) ASSERT_GT(t.share_heard(n), 0.7) << "seed " << seed;
  }
}

TEST(Rekey, WithoutAnAnswerTheKeysStay) {
  Talk t(3);
  t.run(1);
  int asked = 0;
  t.lets_through = [&](std::size_t, const wire::Bytes& d) {
    asked += is_message(d, kRekey) ? 1 : 0;
    return !is_message(d, kRekey);
  };
  t.run(1200);
  EXPECT_EQ(t.rekeys(0), 1U);
  for (std::size_t n : {0U, 1U}) EXPECT_GT(t.share_heard(n), 0.999);
  EXPECT_GT(asked, 100);
  EXPECT_LT(asked, 300) << "every 10 s at last";
  t.lets_through = nullptr;
  t.run(11);
  EXPECT_EQ(t.rekeys(0), 2U);
  EXPECT_EQ(t.rekeys(1), 2U);
}

// Each message of the exchange may be the last one that gets through for minutes.
TEST(Rekey, APartitionAtAnyMomentHeals) {
  for (std::size_t last = 0; last < 6; ++last) {
    Talk t(4);
    t.run(119);
    std::size_t messages = 0;
    t.lets_through = [&](std::size_t, const wire::Bytes& d) {
      messages += wire::is_handshake(d) ? 1U : 0U;
      return messages <= last;
    };
    t.run(200);
    EXPECT_GT(messages, last);
    t.lets_through = nullptr;
    t.run(3);
    t.mark();
    t.run(1);
    for (std::size_t n : {0U, 1U}) EXPECT_GT(t.share_heard(n), 0.95) << last << " messages passed";
    EXPECT_GE(t.rekeys(0), 2U);
  }
}

TEST(Rekey, APeerThatStandsStillOrMovesMeanwhileStaysInTouch) {
  for (const Micros before : {100, 119, 120, 121}) {
    Talk t(5);
    t.run(static_cast<double>(before));
    t.still[0] = true;
    t.run(40);
    t.still[0] = false;
    t.at[0] = place(7);
    t.run(2);
    t.mark();
    t.run(10);
    for (std::size_t n : {0U, 1U}) EXPECT_GT(t.share_heard(n), 0.99) << before;
    EXPECT_EQ(t.rekeys(0), t.rekeys(1));
    EXPECT_EQ(t.heard_twice, 0U);
  }
}

TEST(Rekey, NothingOfBeforePassesASecondTimeWithNewKeys) {
  Talk t(6);
  std::vector<std::pair<std::size_t, wire::Bytes>> recorded;
  t.lets_through = [&](std::size_t from, const wire::Bytes& d) {
    recorded.emplace_back(from, d);
    return true;
  };
  t.run(118);
  recorded.erase(recorded.begin(), recorded.end() - 2000);
  t.run(6);
  ASSERT_EQ(t.rekeys(0), 2U);
  t.lets_through = nullptr;
  t.run(0.1);
  for (const Endpoint& from : {place(1), place(2), place(9)})
    for (const auto& [sender, d] : recorded)
      for (std::size_t to : {0U, 1U}) EXPECT_FALSE(t.deliver(to, from, d));
  t.run(20);
  EXPECT_EQ(t.rekeys(0), 2U);
  EXPECT_GT(t.share_heard(0), 0.99);
}

// Those of its own time that it held back, too: an old introduction by the first keys would take a channel back to
// them.
TEST(Rekey, AnAttackerThatRepeatsOrHoldsBackMessagesGetsNothing) {
  Talk t(7);
  std::vector<std::pair<std::size_t, wire::Bytes>> recorded;
  std::vector<std::pair<std::size_t, wire::Bytes>> held;
  int n = 0;
  t.lets_through = [&](std::size_t from, const wire::Bytes& d) {
    if (!wire::is_handshake(d)) return true;
    if (++n % 3 == 0) {
      held.emplace_back(from, d);
      return false;
    }
    recorded.emplace_back(from, d);
    return true;
  };
  t.run(245);
  ASSERT_GE(t.rekeys(0), 2U);
  ASSERT_FALSE(held.empty());
  t.lets_through = nullptr;
  t.run(15);
  const std::uint64_t rekeys = t.rekeys(1);
  for (int round = 0; round < 50; ++round) {
    for (const auto* all : {&recorded, &held})
      for (const auto& [from, d] : *all) t.deliver(1 - from, round % 2 == 0 ? t.at[from] : place(66), d);
    t.mark();
    t.run(0.5);
    EXPECT_GT(t.share_heard(0), 0.9) << round;
    EXPECT_GT(t.share_heard(1), 0.9) << round;
  }
  EXPECT_EQ(t.rekeys(1), rekeys);
  EXPECT_EQ(t.heard_twice, 0U);
}

/// What in a sealed datagram comes from the key and the nonce alone, if the text is known.
std::string keystream(const wire::Bytes& d, const wire::Bytes& plain) {
  std::string out;
  for (std::size_t i = wire::kHeaderBytes; i < plain.size() - wire::kTagBytes; ++i)
    out.push_back(static_cast<char>(d[i + 8] ^ plain[i]));
  return out;
}

TEST(Rekey, ARestoredSnapshotRepeatsNoNonceAndNoKey) {
  TwoPeers g(wire::SealMode::kEncrypt);
  g.meet();
  SecureChannels copy = g.a;
  Endpoint b = place(2);
  b.key = g.b.key();
  std::set<std::string> streams;
  std::size_t datagrams = 0;
  std::map<wire::Bytes, int> exchange_keys;
  for (int i = 0; i < 130 * 60; ++i) {
    g.now += 16'667;
    for (SecureChannels* one : {&g.a, &copy}) {
      // 40 bytes, other ones in each.
      const char whose = one == &copy ? 'c' : 'a';
      const wire::Bytes plain = words(std::to_string(1'000'000 + i) + std::string(33, whose));
      one->send(b, kNoPeer, plain, g.now);
      for (const auto& p : taken(*one)) {
        if (is_message(p.bytes, kRekey)) ++exchange_keys[wire::Bytes(p.bytes.begin() + 4, p.bytes.begin() + 36)];
        if (!wire::read_sealed(p.bytes)) continue;
        ++datagrams;
        streams.insert(keystream(p.bytes, plain));
      }
    }
  }
  EXPECT_EQ(datagrams, 2U * 130 * 60);
  EXPECT_EQ(streams.size(), datagrams);
  EXPECT_EQ(exchange_keys.size(), 2U) << "one of each, repeated";
}

// The thief of the session's key and of the memory of both peers after some minutes.
TEST(Rekey, WhoHasTheKeyAndALaterStateOpensNothingOfBefore) {
  constexpr std::uint64_t kSeed = 8;
  Talk t(kSeed, wire::SealMode::kEncrypt);
  t.run(1);
  std::vector<wire::Bytes> recorded;
  t.lets_through = [&](std::size_t, const wire::Bytes& d) {
    if (wire::read_sealed(d)) recorded.push_back(d);
    return true;
  };
  t.run(100);
  t.lets_through = nullptr;
  t.run(30);
  ASSERT_EQ(t.rekeys(0), 2U);
  const auto secret = [&](std::uint64_t n) { return wire::derive_key(channel_config(2 * kSeed + n).seed, "secret"); };
  const auto first = wire::pair_keys(channel_config(0).session, secret(0), t.peers[0].key(), t.peers[1].key());
  ASSERT_TRUE(first);
  std::vector<wire::Key> stolen{first->in, first->out};
  EXPECT_EQ(t.told[0][0], first->out) << "the first keys of the two";
  stolen.insert(stolen.end(), t.told[0].end() - 2, t.told[0].end());
  const auto opened_by = [&](const std::vector<wire::Key>& keys) {
    std::size_t opened = 0;
    for (const wire::Bytes& d : recorded)
      for (const wire::Key& key : keys) opened += wire::unseal_with(key, wire::read_sealed(d)->number, d) ? 1U : 0U;
    return opened;
  };
  EXPECT_EQ(opened_by(stolen), 0U);
  EXPECT_EQ(opened_by({t.told[0][2], t.told[0][3]}), recorded.size()) << "the keys of that time do";
}

TEST(Rekey, MessagesThatProveNothingAreNotAnswered) {
  Talk t(9);
  t.run(1);
  const wire::Rekey forged{t.peers[1].key(), 1'000'000, wire::short_id(t.peers[0].key()), 2, 0};
  for (const std::uint32_t generation : {0U, 1U, 2U, 3U, 0xFFFFFFFFU}) {
    wire::Rekey r = forged;
    r.generation = generation;
    EXPECT_FALSE(t.deliver(1, place(1), wire::encode_handshake(r, key_of(77))));
    EXPECT_TRUE(taken(t.peers[1]).empty());
  }
  EXPECT_EQ(t.dropped(1, ChannelDrop::kTag), 5U);
}

}  // namespace
}  // namespace padr::test
