#include <gtest/gtest.h>

#include <deque>

#include "common/link/shim.h"
#include "tests/link/harness.h"

namespace padr::link {
namespace {

using testing::Out;
using testing::Script;

constexpr std::size_t kWhole = kOpportunityBytes - kHeaderBytes;  ///< payload that fills an opportunity
constexpr std::size_t kHalf = kOpportunityBytes / 2 - kHeaderBytes;

TEST(ShimTrace, APacketWaitsForTheNextOpportunity) {
  Script s("trace 10,20,100");
  s.at(0).send("a", kWhole).send("b", kWhole).send("c", kWhole);
  s.expect_at(10'000, {"a"}).expect_at(20'000, {"b"}).expect_at(100'000, {"c"}).empty();
}

TEST(ShimTrace, WhatNobodyUsesIsLost) {
  Script s("trace 10,20,100");
  s.at(20'001).send("a", kWhole).send("b", kWhole).expect_at(100'000, {"a"}).expect_at(110'000, {"b"}).empty();
}

TEST(ShimTrace, AnOpportunityIsThereAtItsTimeAndNotAfter) {
  Script("trace 10,100").at(9'999).send("a").expect_at(10'000, {"a"});
  Script("trace 10,100").at(10'000).send("a").expect({"a"}).empty();
  Script("trace 10,100").at(10'001).send("a").expect_at(100'000, {"a"}).empty();
}

TEST(ShimTrace, BeginsAgainWhenItIsOver) {
  Script s("trace 10,30");
  for (int i = 0; i < 5; ++i) s.at(0).send(std::string(1, static_cast<char>('a' + i)), kWhole);
  s.expect_at(10'000, {"a"}).expect_at(30'000, {"b"}).expect_at(40'000, {"c"}).expect_at(60'000, {"d"});
  s.expect_at(70'000, {"e"}).empty();
  s.at(3'600'000'000).send("f").expect({"f"});  // the end of a repetition
  s.at(3'600'000'001).send("g").expect_at(3'600'010'000, {"g"}).empty();
}

TEST(ShimTrace, NothingPassesBeforeTheFirstLine) {
  Script("trace 10,30").at(0).send("a").expect_at(10'000, {"a"});
  Script("trace 0,30").at(0).send("a").expect({"a"});
  Script("trace 10,30").at(-500'000).send("a").expect_at(10'000, {"a"});
  // The last line of a repetition and the first of the next are two opportunities at one time.
  Script("trace 0,30").at(1).send("a", kWhole).send("b", kWhole).send("c", kWhole).at(30'000).expect({"a", "b"});
}

TEST(ShimTrace, ALineMayBeThereSeveralTimes) {
  Script s("trace 10,10,10,50");
  s.at(0).send("a", kWhole).send("b", kWhole).send("c", kWhole).send("d", kWhole);
  s.expect_at(10'000, {"a", "b", "c"}).expect_at(50'000, {"d"}).empty();
}

TEST(ShimTrace, SmallPacketsShareAnOpportunity) {
  Script s("trace 10,20");
  s.at(0).send("a", kHalf).send("b", kHalf).send("c").expect_at(10'000, {"a", "b"}).expect_at(20'000, {"c"});
  // The rest of an opportunity is there for all who come at its time, and not later.
  s.at(30'000).send("d", kHalf).expect({"d"}).send("e", kHalf).expect({"e"}).send("f").nothing();
  s.expect_at(40'000, {"f"}).at(40'001).send("g").expect_at(50'000, {"g"}).empty();
}

TEST(ShimTrace, APacketGoesOnWithTheNextOpportunity) {
  Script s("trace 10,20");
  // b finds half an opportunity at 10 ms, and needs a byte more.
  s.at(0).send("a", kHalf).send("b", kHalf + 1).send("c", kHalf).send("d", kHalf);
  s.expect_at(10'000, {"a"}).expect_at(20'000, {"b", "c"}).expect_at(30'000, {"d"}).empty();
  // Longer than an opportunity: three of them.
  s.at(30'001).send("e", 2 * kOpportunityBytes).at(59'999).nothing().at(60'000).expect({"e"}).empty();
}

TEST(ShimTrace, HeadersCount) {
  Script s("trace 10,20");
  s.at(0).send("a", kWhole).send("b", kWhole + 1).send("c", kWhole);
  s.expect_at(10'000, {"a"}).at(30'000).expect({"b"}).at(40'000).expect({"c"}).empty();
}

TEST(ShimTrace, DelayComesFirst) {
  Script s("delay 15ms trace 10,20,100");
  s.at(0).send("a").expect_at(20'000, {"a"});
  s.at(5'000).send("b").at(20'000).nothing().expect_at(100'000, {"b"}).empty();  // due at 20 ms, when room is left
}

TEST(ShimTrace, LossComesFirst) {
  Script s("loss gemodel 100% 100% trace 10,20,30");  // every second one
  s.at(0).send("a", kWhole).send("b", kWhole).send("c", kWhole).send("d", kWhole);
  s.expect_at(10'000, {"a"}).expect_at(20'000, {"c"}).empty();
  EXPECT_EQ(s.stats().lost, 2U);
}

TEST(ShimTrace, LimitDropsTheTail) {
  Script s("trace 10,20,100 limit 2");
  s.at(0).send("a", kWhole).send("b", kWhole).send("c", kWhole);
  EXPECT_EQ(s.stats().overlimit, 1U);
  s.at(10'000).send("d", kWhole).expect({"a"}).expect_at(20'000, {"b"}).expect_at(100'000, {"d"}).empty();
  EXPECT_EQ(s.stats().overlimit, 1U);
}

TEST(ShimTrace, ReorderedPacketsAreNotDelayedButWait) {
  Script s("delay 50ms reorder 100% gap 2 trace 10,20,30");
  s.at(0).send("a").send("b").expect_at(10'000, {"b"}).expect_at(50'000, {"a"}).empty();
  EXPECT_EQ(s.stats().reordered, 1U);
}

TEST(ShimTrace, StartIsWhereTheClocksZeroIs) {
  Script("trace 10,20,100 15ms")
      .at(0)
      .send("a", kWhole)
      .send("b", kWhole)
      .expect_at(5'000, {"a"})
      .expect_at(85'000, {"b"});
  Script("trace 10,20,100 215ms").at(0).send("a").expect_at(5'000, {"a"}).empty();  // the third repetition
  Script("trace 10,20,100 100ms").at(0).send("a").expect_at(10'000, {"a"}).empty();
}

TEST(ShimTrace, RandomStartDependsOnTheSeedAlone) {
  const NetemSpec spec = testing::parse("trace 1000000 random");
  const auto first = [&spec](std::uint64_t seed, Micros at) {
    Shim shim(spec, seed);
    shim.accept(at, testing::bytes_of("a"));
    return *shim.next_due();
  };
  EXPECT_EQ(first(1, 0), first(1, 0));
  EXPECT_EQ(first(1, 0), first(1, first(1, 0)));  // it is the clock that counts, not the first packet
  EXPECT_NE(first(1, 0), first(2, 0));
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 1'000; ++seed) {
    const Micros at = first(derive_seed(testing::seed(), seed), 0);
    ASSERT_GT(at, 0);
    ASSERT_LE(at, 1'000'000'000);
    sum += static_cast<double>(at) / 1e9;
  }
  // Uniform: deviation 1 / sqrt(12).
  EXPECT_NEAR(sum / 1'000, 0.5, 6 * 0.289 / std::sqrt(1'000.0)) << testing::seed_note();
}

TEST(ShimTrace, NewRulesKeepThePlaceInTheTrace) {
  Script s("trace 10,20,100");
  s.at(0).send("a", kWhole).send("b", kWhole).expect_at(10'000, {"a"});
  s.at(15'000).change("trace 10,20,100 loss 0.1%").expect_at(20'000, {"b"}).empty();
  s.at(21'000).send("c").at(22'000).change("").expect({"c"}).empty();
  // What was held before the trace gets no opportunity that has passed.
  s.change("slot 500ms packets 1").send("d").send("e").expect({"d"});
  s.at(115'000).change("trace 10,20,100").nothing().expect_at(120'000, {"e"}).empty();
  // A packet that was on its way in part is sent anew.
  s.at(205'000).send("f", 2 * kWhole).at(210'000).nothing().at(215'000).change("trace 10,20,100");
  s.at(220'000).nothing().at(299'999).nothing().at(300'000).expect({"f"}).empty();
}

TEST(ShimTrace, LongestTraceAndLatestTimes) {
  Script("trace 4294967295").at(1).send("a").expect_at(4'294'967'295'000, {"a"}).empty();
  Script s("trace 1");
  const Micros late = Micros{1} << 51U;
  s.at(late - 1).send("a").expect_at((late + 999) / 1'000 * 1'000, {"a"}).empty();
}

/// mahimahi's own loop: at each opportunity, the bytes of those who have come before it, in their order.
std::vector<Out> as_mahimahi(const std::vector<std::uint32_t>& times,
                             const std::vector<std::pair<Micros, std::size_t>>& in) {
  std::vector<Out> out;
  std::size_t head = 0;
  std::int64_t head_left = -1;
  for (Micros base = 0; head < in.size(); base += Micros{times.back()} * 1'000) {
    for (const std::uint32_t ms : times) {
      const Micros now = base + Micros{ms} * 1'000;
      std::int64_t left = kOpportunityBytes;
      while (left > 0 && head < in.size() && in[head].first <= now) {
        if (head_left < 0) head_left = static_cast<std::int64_t>(in[head].second + kHeaderBytes);
        const std::int64_t n = std::min(left, head_left);
        left -= n;
        head_left -= n;
        if (head_left > 0) break;
        out.push_back({now, static_cast<std::uint32_t>(head++)});
        head_left = -1;
      }
    }
  }
  return out;
}

TEST(ShimTrace, DoesWhatMahimahisLoopDoes) {
  for (std::uint64_t round = 0; round < 200; ++round) {
    Rng rng(derive_seed(testing::seed(), round));
    std::string spec;
    std::vector<std::uint32_t> times;
    const auto lines = 1 + rng.below(12);
    for (std::uint32_t i = 0; i < lines; ++i) {
      times.push_back((times.empty() ? 0 : times.back()) + (rng.chance(0.3) ? 0 : rng.below(20)));
      if (i + 1 == lines) ++times.back();
      spec += (spec.empty() ? "trace " : ",") + std::to_string(times.back());
    }
    SCOPED_TRACE(spec + "; round " + std::to_string(round) + "; " + testing::seed_note());
    Shim shim(testing::parse(spec), 1);
    std::vector<std::pair<Micros, std::size_t>> in;
    std::vector<Out> out;
    Micros now = 1;
    const auto collect_until = [&](Micros end) {
      for (auto due = shim.next_due(); due && *due <= end; due = shim.next_due())
        while (const auto bytes = shim.release(*due)) out.push_back({*due, testing::number_of(*bytes)});
    };
    for (std::uint32_t i = 0; i < 300; ++i) {
      now += rng.chance(0.4) ? 0 : rng.below(rng.chance(0.1) ? 100'000 : 5'000);
      in.emplace_back(now, 4 + rng.below(rng.chance(0.1) ? 9'000 : 700));
      collect_until(now);
      shim.accept(now, testing::numbered(i, in.back().second));
    }
    collect_until(Micros{1} << 50U);
    ASSERT_EQ(out, as_mahimahi(times, in));
  }
}

}  // namespace
}  // namespace padr::link
