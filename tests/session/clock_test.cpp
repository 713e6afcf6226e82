#include <gtest/gtest.h>

#include "common/model/rng.h"
#include "common/replica/link_clock.h"
#include "common/session/session_clock.h"

namespace padr::test {
namespace {

using node::OffsetEstimator;
using node::SessionClock;

TEST(OffsetEstimator, LeastDelaysOfEachWayCount) {
  OffsetEstimator e;
  EXPECT_EQ(e.offset(), 0);
  // Theirs is 1,000,000 ahead. Forth 10 ms and back 90 ms, then the other way round: the best of both.
  e.add(0, 1'010'000, 100'000);
  EXPECT_EQ(e.offset(), 960'000);
  e.add(200'000, 1'290'000, 300'000);
  EXPECT_EQ(e.offset(), 1'000'000);
  EXPECT_EQ(e.round_trip(), 100'000);
  e.add(400'000, 1'405'000, 410'000);
  EXPECT_EQ(e.offset(), 1'000'000);
  EXPECT_EQ(e.round_trip(), 10'000);
}

TEST(OffsetEstimator, TimesThatDoNotFitEachOther) {
  for (const Micros told : {OffsetEstimator::kTolerance, OffsetEstimator::kTolerance + 1}) {
    OffsetEstimator e;
    EXPECT_FALSE(e.is_contradictory());
    e.add(0, 10'000, 20'000);  // theirs is behind by 10 ms, or ahead by 10 ms, or anything between
    EXPECT_FALSE(e.is_contradictory());
    e.add(30'000, 50'000 + 10'000 + told, 50'000);
    EXPECT_EQ(e.is_contradictory(), told > OffsetEstimator::kTolerance);
  }
}

TEST(OffsetEstimator, OldSamplesAreForgotten) {
  OffsetEstimator e;
  e.add(0, 5'000, 0);
  for (std::size_t i = 0; i < OffsetEstimator::kKept; ++i) e.add(0, 9'000, 0);
  EXPECT_EQ(e.offset(), 9'000);
  EXPECT_EQ(e.samples(), OffsetEstimator::kKept);
}

TEST(OffsetEstimator, WithinATickOfTheTruthUnderJitter) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Rng rng(seed);
    OffsetEstimator e;
    for (int i = 0; i < 16; ++i) {
      const Micros sent = i * 50'000;
      const auto forth = static_cast<Micros>(rng.uniform(50'000, 150'000));
      const auto back = static_cast<Micros>(rng.uniform(50'000, 150'000));
      e.add(sent, sent + forth - 77'000, sent + forth + back);
    }
    EXPECT_NEAR(static_cast<double>(e.offset()), -77'000, 16'667) << "seed " << seed;
  }
}

TEST(SessionClock, StepsBeforeItRunsAndSlewsAfterwards) {
  SessionClock c;
  c.set(-5'000'000);
  EXPECT_EQ(c.now(4'000'000), -1'000'000);
  c.set(-4'500'000);
  EXPECT_EQ(c.now(4'500'000), 0);
  EXPECT_EQ(c.local_at(1'000'000), 5'500'000);
  c.steer(4'500'000, 10'000'000);  // far ahead: as slow as is allowed
  EXPECT_EQ(c.now(4'500'000), 0) << "no jump";
  EXPECT_EQ(c.now(5'500'000), 995'000);
  c.steer(5'500'000, -10'000'000);
  EXPECT_EQ(c.now(5'500'000), 995'000);
  EXPECT_EQ(c.now(6'500'000), 2'000'000);
  c.steer(6'500'000, 0);
  EXPECT_EQ(c.now(7'500'000), 3'000'000);
}

TEST(SessionClock, NeverGoesBackAndDeadlinesAreNeverEarly) {
  Rng rng(3);
  SessionClock c;
  c.set(1'234);
  Micros local = 0;
  Micros last = c.now(local);
  for (int i = 0; i < 10'000; ++i) {
    if (rng.chance(0.2)) c.steer(local, static_cast<Micros>(rng.uniform(-500'000, 500'000)));
    const Micros wanted = c.now(local) + rng.below(40'000);
    EXPECT_GE(c.now(c.local_at(wanted)), wanted);
    EXPECT_LE(c.now(c.local_at(wanted)), wanted + 2);
    local += rng.below(20'000);
    const Micros now = c.now(local);
    ASSERT_GE(now, last);
    last = now;
  }
}

// Two peers whose clocks disagree at first and drift apart: the second follows the first by what LinkClock measures
// over a jittery link, and neither swings nor is left behind.
TEST(SessionClock, FollowsAnotherPeerThroughJitter) {
  for (const double drift : {0.0, 100e-6, -100e-6}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Rng rng(seed);
      SessionClock ours;
      ours.set(40'000);  // 40 ms ahead
      node::LinkClock here;
      node::LinkClock there;
      double worst_late = 0;
      double previous = 1e9;
      for (Micros t = 0; t < 180 * kMicrosPerSecond; t += 250'000) {
        const auto local = t + static_cast<Micros>(static_cast<double>(t) * drift);
        const Micros mine = ours.now(local);
        // A datagram each way, stamped with whole ticks; the delays are drawn when it is sent.
        const auto to_us = static_cast<Micros>(rng.uniform(80'000, 120'000));
        const auto to_them = static_cast<Micros>(rng.uniform(80'000, 120'000));
        here.sample(static_cast<Tick>(t * kTicksPerSecond / kMicrosPerSecond), mine + to_us);
        there.sample(static_cast<Tick>(mine * kTicksPerSecond / kMicrosPerSecond), t + to_them);
        here.told(static_cast<std::int32_t>(there.least() / 100));
        ours.steer(local, here.lead());
        const double lead = std::abs(static_cast<double>(ours.now(local) - t));
        if (t > 60 * kMicrosPerSecond) worst_late = std::max(worst_late, lead);
        if (t % (30 * kMicrosPerSecond) == 0 && t <= 60 * kMicrosPerSecond) {
          EXPECT_LT(lead, previous) << "at " << t;
          previous = lead;
        }
      }
      EXPECT_LT(worst_late, 12'000) << "drift " << drift << " seed " << seed;
    }
  }
}

}  // namespace
}  // namespace padr::test
