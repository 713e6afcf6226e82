#include <gtest/gtest.h>

#include "common/link/shim.h"
#include "shell/netem_text.h"
#include "tests/link/harness.h"

namespace padr::link {
namespace {

using testing::Out;
using testing::Script;

// A payload of 972 bytes is 1,000 on the wire: 8 ms at 1 Mbit/s.
constexpr std::size_t kPayload = 1000 - kHeaderBytes;

TEST(ShimRate, PacketsQueueBehindOneAnother) {
  Script s("rate 1mbit");
  s.at(0).send("a", kPayload).send("b", kPayload).send("c", kPayload);
  s.expect_at(8'000, {"a"}).expect_at(16'000, {"b"}).expect_at(24'000, {"c"}).empty();
  s.at(100'000).send("d", kPayload).expect_at(108'000, {"d"}).empty();  // an idle link saves nothing up
}

TEST(ShimRate, BytesPerSecond) {
  Script("rate 125kbps").at(0).send("a", kPayload).expect_at(8'000, {"a"});
}

TEST(ShimRate, WaitingForTheLineCountsAsDelay) {
  Script s("delay 100ms rate 1mbit");
  s.at(0).send("a", kPayload).send("b", kPayload);
  // b waits 8 ms for the line; its 100 ms of delay run meanwhile and after a has been sent nothing is left of them.
  s.expect_at(108'000, {"a"}).expect_at(116'000, {"b"}).empty();
}

TEST(ShimRate, ShortBacklogLeavesTheRestOfTheDelay) {
  Script s("delay 10ms rate 1mbit");
  s.at(0).send("a", kPayload);       // until 18 ms
  s.at(15'000).send("b", kPayload);  // 3 ms of its 10 ms are over when a is out: 18 + 7 + 8
  s.expect_at(18'000, {"a"}).expect_at(33'000, {"b"}).empty();
}

TEST(ShimRate, OverheadMayBeNegative) {
  Script("rate 1mbit 250").at(0).send("a", kPayload).expect_at(10'000, {"a"});
  Script("rate 1mbit -500").at(0).send("a", kPayload).expect_at(4'000, {"a"});
  Script("rate 1mbit -5000").at(0).send("a", kPayload).expect({"a"});
}

TEST(ShimRate, CellsAreRoundedUp) {
  // tc-netem(8)'s example: 50 bytes are two ATM cells of 48 + 5, 106 bytes: 1 ms at 848 kbit/s.
  Script("rate 848kbit 0 48 5").at(0).send("a", 50 - kHeaderBytes).expect_at(1'000, {"a"});
  Script("rate 848kbit 0 48 5").at(0).send("a", 96 - kHeaderBytes).expect_at(1'000, {"a"});
  Script("rate 848kbit 0 48 5").at(0).send("a", 97 - kHeaderBytes).expect_at(1'500, {"a"});
}

TEST(ShimRate, JitterDoesNotReorder) {
  Shim shim(shell::parse_netem("delay 100ms 90ms rate 1mbit"), testing::seed());
  const auto out = testing::stream(shim, 5'000, 1'000, 72);
  ASSERT_EQ(out.size(), 5'000U);
  for (std::size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i].number, i) << testing::seed_note();
}

TEST(ShimRate, ASaturatedLinkCarriesItsRate) {
  // 1,000-byte packets offered at 2 Mbit/s to 1 Mbit/s, for 10 s: one comes out every 8 ms, the queue holds 1,000.
  Shim shim(shell::parse_netem("rate 1mbit limit 1000"), testing::seed());
  const auto out = testing::stream(shim, 2'500, 4'000, kPayload);
  EXPECT_EQ(out.size(), 2'500U - shim.stats().overlimit);
  for (std::size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i].at, 8'000 * static_cast<Micros>(i + 1));
  EXPECT_EQ(shim.stats().overlimit, 2'500U - 1'249U - 1'000U);  // in, out by the last arrival at 9.996 s, and held
}

TEST(ShimSlot, PacketsWaitForTheSlot) {
  Script s("slot 10ms");
  s.at(0).send("a").nothing().at(3'000).send("b").nothing();
  s.expect_at(10'000, {"a", "b"}).empty();
  s.at(12'000).send("c").expect_at(22'000, {"c"}).empty();  // the slot of 10 ms has passed
}

TEST(ShimSlot, ASlotIsDrawnWhenTheQueueIsLookedAt) {
  // Due at 15 ms. The slot drawn on arrival, for 10 ms, has passed by then, so another is drawn, for 25 ms.
  Script("delay 15ms slot 10ms").at(0).send("a").at(15'000).nothing().at(24'999).nothing().at(25'000).expect({"a"});
}

TEST(ShimSlot, PacketsPerSlot) {
  Script s("slot 10ms packets 2");
  s.at(0).send("a").send("b").send("c").send("d").send("e");
  s.expect_at(10'000, {"a", "b"}).expect_at(20'000, {"c", "d"}).expect_at(30'000, {"e"}).empty();
}

TEST(ShimSlot, BytesPerSlotCountHeadersAndMayRunOver) {
  Script s("slot 10ms bytes 250");
  for (const char* name : {"a", "b", "c", "d"}) s.at(0).send(name, 100 - kHeaderBytes);
  s.expect_at(10'000, {"a", "b", "c"}).expect_at(20'000, {"d"}).empty();
}

TEST(ShimSlot, TimesAreUniformBetweenMinAndMax) {
  Shim shim(shell::parse_netem("slot 10ms 30ms"), testing::seed());
  const auto out = testing::stream(shim, 20'000, 1'000'000);
  double sum = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Micros wait = out[i].at - static_cast<Micros>(i) * 1'000'000;
    ASSERT_GE(wait, 10'000);
    ASSERT_LE(wait, 30'000);
    sum += static_cast<double>(wait);
  }
  // Uniform over 20 ms: deviation 20 / sqrt(12) = 5.77 ms.
  EXPECT_NEAR(sum / 20'000, 20'000, 6 * 5'774 / std::sqrt(20'000.0)) << testing::seed_note();
}

TEST(ShimSlot, DistributionShapesTheSlots) {
  Shim shim(shell::parse_netem("slot distribution normal 50ms 5ms"), testing::seed());
  const auto out = testing::stream(shim, 20'000, 1'000'000);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double wait = static_cast<double>(out[i].at - static_cast<Micros>(i) * 1'000'000);
    sum += wait;
    squares += wait * wait;
  }
  const double mean = sum / 20'000;
  EXPECT_NEAR(mean, 50'000, 6 * 5'000 / std::sqrt(20'000.0)) << testing::seed_note();
  EXPECT_NEAR(std::sqrt(squares / 20'000 - mean * mean), 5'000, 6 * 5'000 / std::sqrt(40'000.0) + 1);
}

TEST(ShimSlot, ReorderedPacketsDoNotWait) {
  Script("delay 1ms reorder 100% gap 2 slot 50ms").at(0).send("a").send("b").expect({"b"}).at(100'000).expect({"a"});
}

}  // namespace
}  // namespace padr::link
