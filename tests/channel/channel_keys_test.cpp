#include "common/channel/channel_keys.h"

#include "tests/channel/two_peers.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

using node::ChannelKeys;

/// The keys of two peers, between which whoever tests carries what is told.
struct Pair {
  Pair() : Pair(*wire::pair_keys(key_of(1), key_of(2), wire::public_key(key_of(2)), wire::public_key(key_of(3)))) {}
  explicit Pair(const wire::PairKeys& k) : a(k, true, 0), b({k.in, k.out}, false, 0) {}
  ChannelKeys a;
  ChannelKeys b;
  std::uint64_t number = 0;
  node::RandomBytes random = random_bytes(5);
  Micros now = 0;

  /// All messages, until nobody has anything to say.
  void exchange() {
    std::optional<wire::Rekey> to_b = a.due(now, random);
    while (to_b) {
      to_b->number = ++number;
      const auto from_b = b.take(*to_b, now, random);
      to_b.reset();
      if (from_b.confirm) opens(a, b, now);
      if (!from_b.rekey) break;
      wire::Rekey to_a = *from_b.rekey;
      to_a.number = ++number;
      const auto from_a = a.take(to_a, now, random);
      if (from_a.confirm) opens(b, a, now);
      to_b = from_a.rekey;
    }
    opens(a, b, now);
    opens(b, a, now);
  }
  /// Whether `to` can open what `from` seals now.
  static bool opens(ChannelKeys& to, const ChannelKeys& from, Micros now) {
    return to.open([&](const wire::Key& key) { return key == from.out(); }, now);
  }
};

TEST(ChannelKeys, BothGoOverAndTheFormerKeyLastsForAWhile) {
  Pair p;
  const wire::Key before = p.a.out();
  p.exchange();
  EXPECT_EQ(p.a.generation(), 1U);
  EXPECT_EQ(p.b.generation(), 1U);
  EXPECT_NE(p.a.out(), before);
  const auto opens_late = [&](Micros at) { return p.b.open([&](const wire::Key& key) { return key == before; }, at); };
  EXPECT_TRUE(opens_late(ChannelKeys::kOverlap - 1));
  EXPECT_FALSE(opens_late(ChannelKeys::kOverlap)) << "wiped";
  EXPECT_TRUE(Pair::opens(p.b, p.a, p.now));
  EXPECT_TRUE(Pair::opens(p.a, p.b, p.now));
}

TEST(ChannelKeys, TheFormerKeyStaysUntilTheOtherIsHeardToFollow) {
  Pair p;
  auto to_b = *p.a.due(0, p.random);
  to_b.number = 1;
  auto to_a = *p.b.take(to_b, 0, p.random).rekey;
  to_a.number = 1;
  EXPECT_TRUE(p.a.take(to_a, 0, p.random).confirm);
  EXPECT_EQ(p.a.generation(), 1U);
  EXPECT_EQ(p.b.generation(), 0U) << "has heard nothing of it";
  constexpr Micros kHour = 3600 * kMicrosPerSecond;
  EXPECT_TRUE(Pair::opens(p.a, p.b, kHour));
  EXPECT_FALSE(p.a.due(kHour, p.random)) << "one after the other";
  // b asks again, and is told again.
  auto again = *p.b.due(kHour, p.random);
  again.number = 2;
  ASSERT_NE(p.a.key_of(again.generation), nullptr);
  EXPECT_EQ(*p.a.key_of(again.generation), p.b.out());
  EXPECT_TRUE(p.a.take(again, kHour, p.random).confirm);
  EXPECT_TRUE(Pair::opens(p.b, p.a, kHour));
  EXPECT_EQ(p.b.generation(), 1U);
}

TEST(ChannelKeys, TimesAreAsTold) {
  Pair p;
  p.exchange();
  const Micros every = ChannelKeys::kEvery;
  EXPECT_FALSE(p.a.due(every - 1, p.random));
  EXPECT_FALSE(p.b.due(every + ChannelKeys::kPatience - 1, p.random));
  ASSERT_TRUE(p.a.due(every, p.random));
  Micros at = every;
  for (const Micros wait : {1, 2, 4, 8, 16, 32, 50, 50, 50}) {
    at += wait * ChannelKeys::kAgain;
    EXPECT_FALSE(p.a.due(at - 1, p.random)) << wait;
    EXPECT_TRUE(p.a.due(at, p.random)) << wait;
  }
}

// One has lost its keys just when the other went on.
TEST(ChannelKeys, ANewPairForTheFirstNewKeysTakesBothBackAndOn) {
  Pair p;
  auto to_b = *p.a.due(0, p.random);
  to_b.number = 1;
  auto to_a = *p.b.take(to_b, 0, p.random).rekey;
  to_a.number = 2;
  p.a.take(to_a, 0, p.random);
  ASSERT_EQ(p.a.generation(), 1U);
  EXPECT_TRUE(p.a.may_lag(ChannelKeys::kLag - 1));
  EXPECT_FALSE(p.a.may_lag(ChannelKeys::kLag));
  p.b.restart(0);
  auto anew = *p.b.due(kMicrosPerSecond, p.random);
  anew.number = 3;
  EXPECT_TRUE(p.a.take(anew, 0, p.random).rekey);
  EXPECT_EQ(p.a.generation(), 0U);
  to_a.number = 1;  // which comes late
  EXPECT_FALSE(p.a.take(to_a, 0, p.random).made);
  p.number = 10;
  p.now = kMicrosPerSecond;
  p.exchange();
  EXPECT_EQ(p.a.generation(), 1U);
  EXPECT_EQ(p.b.generation(), 1U);
  EXPECT_TRUE(Pair::opens(p.b, p.a, p.now));
}

TEST(ChannelKeys, WhoAsksTooOftenIsNotFollowed) {
  Pair p;
  p.exchange();
  wire::Rekey soon{wire::exchange_key(key_of(9)), 9, 0, 2, 0};
  EXPECT_FALSE(p.b.take(soon, ChannelKeys::kSoonest - 1, p.random).rekey);
  EXPECT_TRUE(p.b.take(soon, ChannelKeys::kSoonest, p.random).rekey);
}

TEST(ChannelKeys, AnExchangeKeyThatIsNoneMakesNothing) {
  Pair p;
  const auto answer = p.b.take({PublicKey{}, 1, 0, 1, 0}, 0, p.random);
  EXPECT_FALSE(answer.made);
  EXPECT_FALSE(answer.rekey);
  p.exchange();
  EXPECT_EQ(p.b.generation(), 1U);
}

// With messages lost, late and repeated, in any order.
TEST(ChannelKeys, ThereAreNeverMoreThanTwoKeysToTryAndOneAlwaysFits) {
  Rng rng(test::seed());
  Pair p;
  std::vector<wire::Rekey> to_a;
  std::vector<wire::Rekey> to_b;
  const auto say = [&](std::vector<wire::Rekey>& to, std::optional<wire::Rekey> r) {
    if (!r || rng.chance(0.4)) return;
    r->number = ++p.number;
    to.push_back(*r);
  };
  for (int i = 0; i < 200'000; ++i) {
    p.now += rng.chance(0.001) ? ChannelKeys::kEvery : 20'000;
    say(to_b, p.a.due(p.now, p.random));
    say(to_a, p.b.due(p.now, p.random));
    const bool at_b = rng.chance(0.5);
    ChannelKeys& to = at_b ? p.b : p.a;
    ChannelKeys& from = at_b ? p.a : p.b;
    auto& waiting = at_b ? to_b : to_a;
    if (!waiting.empty() && rng.chance(0.3)) {
      const wire::Rekey r = waiting[rng.below(static_cast<std::uint32_t>(waiting.size()))];
      if (r.generation == from.generation() + 1 && to.key_of(r.generation) != nullptr &&
          *to.key_of(r.generation) == from.out())
        say(at_b ? to_a : to_b, to.take(r, p.now, p.random).rekey);
      if (waiting.size() > 20) waiting.erase(waiting.begin());
    }
    int tried = 0;
    const bool hears = rng.chance(0.3);
    const auto opens = [&](const wire::Key& key) { return ++tried, hears && key == from.out(); };
    const bool opened = to.open(opens, p.now);
    ASSERT_EQ(opened, hears) << "turn " << i;
    ASSERT_LE(tried, 2);
  }
  EXPECT_GT(p.a.generation(), 50U);
}

}  // namespace
}  // namespace padr::test
