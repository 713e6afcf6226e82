#include "common/link/shim.h"

#include <gtest/gtest.h>

#include "shell/netem_text.h"
#include "tests/link/harness.h"

namespace padr::link {
namespace {

using testing::Script;

TEST(Shim, PerfectLinkPassesAtOnce) {
  Script("").at(5).nothing().send("a").send("b").expect({"a", "b"}).nothing().empty();
}

TEST(Shim, EmptyDatagramPasses) {
  Script("delay 1ms").at(0).send("").expect_at(1'000, {""}).empty();
}

TEST(Shim, DelayIsExact) {
  Script("delay 100ms").at(7).send("a").nothing().at(10).send("b").expect_at(100'007, {"a"}).expect_at(100'010, {"b"});
}

TEST(Shim, NanosecondsAreRoundedUpNeverEarly) {
  Script("delay 1500ns").at(0).send("a").expect_at(2, {"a"}).empty();
}

TEST(Shim, TimesMayBeNegative) {
  Script("delay 10us").at(-15).send("a").expect_at(-5, {"a"}).empty();
}

TEST(Shim, LateCollectionKeepsTheOrderOfLeaving) {
  Script("delay 1ms").at(0).send("a").at(500).send("b").at(99'000).expect({"a", "b"}).empty();
}

TEST(Shim, TimeDoesNotGoBack) {
  Script("delay 1ms").at(5'000).send("a").at(1'000).send("b").expect_at(6'000, {"a", "b"}).empty();
}

TEST(Shim, LossOfEverything) {
  Script s("loss 100%");
  s.at(0).send("a").send("b").nothing().empty();
  EXPECT_EQ(s.stats().lost, 2U);
  EXPECT_EQ(s.stats().accepted, 2U);
}

TEST(Shim, DuplicatesOnceNotForEver) {
  Script s("duplicate 100% delay 1ms");
  s.at(0).send("a").send("b").expect_at(1'000, {"a", "a", "b", "b"}).empty();
  EXPECT_EQ(s.stats().duplicated, 2U);
  EXPECT_EQ(s.stats().released, 4U);
}

TEST(Shim, DuplicatedAndLostIsExactlyOne) {
  Script s("duplicate 100% loss 100%");
  s.at(0).send("a").expect({"a"}).empty();
  EXPECT_EQ(s.stats().duplicated, 0U);
  EXPECT_EQ(s.stats().lost, 0U);
}

TEST(Shim, CloneSeesLossAnew) {
  // Every second packet of the loss process is lost. Packet a: not lost, so cloned; the clone is.
  Script s("duplicate 100% loss gemodel 100% 100%");
  s.at(0).send("a").expect({"a"}).empty();
  EXPECT_EQ(s.stats().duplicated, 1U);
  EXPECT_EQ(s.stats().lost, 1U);
}

TEST(Shim, LimitDropsTheTailUntilThereIsRoom) {
  Script s("delay 10ms limit 2");
  s.at(0).send("a").send("b").send("c");
  EXPECT_EQ(s.stats().overlimit, 1U);
  s.at(9'999).send("d");
  EXPECT_EQ(s.stats().overlimit, 2U);
  s.at(10'000).send("e").expect({"a", "b"}).expect_at(20'000, {"e"}).empty();
  EXPECT_EQ(s.stats().overlimit, 2U);
}

TEST(Shim, LimitCountsWhatHasNotLeftEvenIfNobodyCollects) {
  Script("delay 1ms limit 1").at(0).send("a").at(1'000).send("b").at(2'000).send("c").at(9'000).expect({"a", "b", "c"});
}

TEST(Shim, LimitZeroDropsEverything) {
  Script s("limit 0");
  s.at(0).send("a").nothing().empty();
  EXPECT_EQ(s.stats().overlimit, 1U);
}

TEST(Shim, EveryFifthIsSentAtOnce) {
  Script s("delay 10ms reorder 100% gap 5");
  s.at(0).send("a").send("b").send("c").send("d").nothing();
  s.at(1).send("e").expect({"e"});
  s.at(2).send("f").send("g").send("h").send("i").nothing();
  s.at(3).send("j").expect({"j"});
  s.expect_at(10'000, {"a", "b", "c", "d"}).expect_at(10'002, {"f", "g", "h", "i"}).empty();
  EXPECT_EQ(s.stats().reordered, 2U);
}

TEST(Shim, ReorderWithoutGapIsGapOne) {
  Script("delay 10ms reorder 100%").at(0).send("a").send("b").expect({"a", "b"}).empty();
}

TEST(Shim, ReorderObeysTheLimit) {
  Script s("delay 10ms reorder 100% gap 2 limit 1");
  s.at(0).send("a").send("b").nothing().expect_at(10'000, {"a"}).empty();
  EXPECT_EQ(s.stats().overlimit, 1U);
}

TEST(Shim, NegativeDelayIsNow) {
  Shim shim(shell::parse_netem("delay 1us 2s limit 10000"), testing::seed());
  int at_once = 0;
  for (int i = 0; i < 10'000; ++i) {
    shim.accept(0, testing::bytes_of("x"));
    while (shim.release(0)) ++at_once;
  }
  // The remainder of a 32-bit number by 4 s in nanoseconds is netem's, with its bias: the lowest 2^32 - 4 * 10^9 values
  // come twice as often. Half, 2 * 10^9 - 1,000 + 1 of the remainders, would be at once without it.
  const double values = 2e9 - 1'000 + 1 + (0x1p32 - 4e9);
  testing::expect_share(at_once, 10'000, values / 0x1p32);
}

TEST(Shim, NewRulesHoldForNewDatagrams) {
  Script s("delay 10ms");
  s.at(0).send("a").at(1'000).change("delay 1ms").send("b").expect_at(2'000, {"b"}).expect_at(10'000, {"a"}).empty();
  s.change("loss 100%").send("c").nothing().change("").send("d").expect({"d"}).empty();
}

TEST(Shim, DroppingSlotsSendsWhatIsDue) {
  Script("slot 50ms").at(0).send("a").at(10).nothing().change("delay 1ms").expect({"a"}).empty();
}

TEST(Shim, StatsAddUpAndCountBytes) {
  Shim shim(shell::parse_netem("delay 5ms 5ms loss 20% duplicate 20% corrupt 20% reorder 10% limit 20"),
            testing::seed());
  std::uint64_t released_bytes = 0;
  for (int i = 0; i < 10'000; ++i) {
    shim.accept(i * 300, testing::numbered(static_cast<std::uint32_t>(i), 10));
    if (i % 7 == 0) {
      while (const auto out = shim.release(i * 300)) released_bytes += out->size();
    }
    const ShimStats& s = shim.stats();
    ASSERT_EQ(s.accepted + s.duplicated, s.released + s.lost + s.overlimit + shim.in_flight()) << "datagram " << i;
  }
  EXPECT_EQ(shim.stats().accepted_bytes, 100'000U);
  EXPECT_EQ(shim.stats().released_bytes, released_bytes);
  EXPECT_GT(shim.stats().overlimit, 0U);
}

}  // namespace
}  // namespace padr::link
