#include <gtest/gtest.h>

#include <algorithm>

#include "tests/lab/session.h"
#include "tests/seed.h"

namespace padr {
namespace {

Technique tight_full() {
  Technique t = technique_by_name("full");
  t.threshold_high = 0.3F;
  t.threshold_low = 0.1F;
  t.body_threshold = 0.05F;
  return t;
}

Technique papers_full() {
  Technique t = technique_by_name("full");
  const Technique paper = technique_by_name("adaptive");
  t.threshold_high = paper.threshold_high;
  t.threshold_low = paper.threshold_low;
  t.body_threshold = 0.1F;
  return t;
}

#if defined(PADR_SANITIZED)
constexpr int kSeeds = 2;
#else
constexpr int kSeeds = 24;
#endif

// With no latency what the others see is what this peer knows they see: then the thresholds bound it, whatever happens.
TEST(Frontier, WithoutLatencyTheThresholdsBoundTheCombinedInconsistency) {
  const std::uint64_t base = test::seed(1);
  for (const Technique& t : {tight_full(), papers_full()}) {
    float worst = 0;
    for (int i = 0; i < kSeeds; ++i) {
      const auto seed = base * 100 + static_cast<std::uint64_t>(i);
      test::Session s("arena", 2, t, "", seed, 60, 0, true);
      s.simulation->run();
      const trace::Inconsistency seen = s.simulation->meter().result(1);
      EXPECT_LE(seen.peak_m, t.threshold_high + t.body_threshold) << "seed " << seed;
      worst = std::max(worst, static_cast<float>(seen.peak_m));
    }
    std::cout << "worst of " << kSeeds << " sessions: " << worst << " m, allowed "
              << t.threshold_high + t.body_threshold << " m\n";
    EXPECT_GT(worst, t.threshold_low) << "or there was nothing to bound";
  }
}

/// What the idle peer sees and what both send, over some seeds.
struct Point {
  double mean_m = 0;
  double kbps = 0;
};

Point point_of(const Technique& t) {
  constexpr int kRuns = kSeeds / 2;
  const std::uint64_t base = test::seed(1);
  Point p;
  for (int i = 0; i < kRuns; ++i) {
    test::Session s("arena", 2, t, "delay 100ms", base * 100 + static_cast<std::uint64_t>(i), 60, 0, true);
    s.simulation->run();
    p.mean_m += s.simulation->meter().result(1).mean_m / kRuns;
    for (PeerId peer = 0; peer < 2; ++peer)
      p.kbps += static_cast<double>(s.simulation->replica(peer).stats().wire_bytes_sent) * 8 / 1000 / 60 / kRuns;
  }
  return p;
}

// One knob leads along the frontier: what is told fits the budget, and the less it is, the rougher.
TEST(Frontier, ABudgetIsKeptByLargerErrors) {
  float rougher = 0;
  for (const float budget : {64.0F, 8.0F, 6.0F}) {
    Technique t = technique_by_name("full");
    t.budget = budget;
    test::Session s("arena", 4, t, "delay 100ms", test::seed(7), 40);
    s.simulation->run();
    float mean = 0;
    for (PeerId p = 0; p < 4; ++p) {
      const double kbps = static_cast<double>(s.simulation->replica(p).stats().wire_bytes_sent) * 8 / 1000 / 40;
      EXPECT_LE(kbps, budget * 1.1) << "peer " << int{p};
      mean += static_cast<float>(s.simulation->meter().result(p).mean_m / 4);
    }
    EXPECT_GT(mean, rougher) << budget;
    EXPECT_EQ(s.simulation->confirmed_mismatches(), 0U);
    rougher = mean;
  }
}

// A link of 1 kbit/s takes 5 s for 600 bytes, and as nobody answers meanwhile, marks follow. What is sent before the
// first answers must not make a queue that never empties.
TEST(Frontier, ALinkOfAKilobitASecondIsSentNoMoreThanItCarries) {
  for (std::uint64_t i = 0; i < 3; ++i) {
    const std::uint64_t seed = test::seed(1) + i;
    test::Session s("arena", 4, technique_by_name("full"), "delay 50ms rate 1kbit limit 100", seed, 60);
    s.simulation->run();
    for (PeerId p = 0; p < 4; ++p) {
      const double kbps = static_cast<double>(s.simulation->replica(p).stats().wire_bytes_sent) * 8 / 1000 / 60;
      EXPECT_LE(kbps, 3.05) << "peer " << int{p} << ", seed " << seed << ": three links";
    }
    EXPECT_EQ(s.simulation->confirmed_mismatches(), 0U);
  }
}

TEST(Frontier, FullIsCloseToTellingEverythingForAFractionOfTheTraffic) {
  Technique everything = technique_by_name("everything");
  everything.model = Model::kFirst;
  Technique on_arrival = everything;
  on_arrival.replay = false;
  Technique fixed = technique_by_name("fixed");
  fixed.threshold_high = fixed.threshold_low = 0.3F;
  const Point full = point_of(tight_full());
  const Point limit = point_of(everything);
  std::cout << "full " << full.mean_m << " m, " << full.kbps << " kbit/s; everything " << limit.mean_m << " m, "
            << limit.kbps << " kbit/s\n";
  EXPECT_LT(full.mean_m, 0.5 * point_of(fixed).mean_m);
  EXPECT_LT(full.mean_m, 0.5 * point_of(on_arrival).mean_m);
  // On recorded human paths it is 1.4 times; made-up motion is smoother, and a straight line a better guess of it.
  EXPECT_LT(full.mean_m, 3 * limit.mean_m);
  EXPECT_LT(full.kbps, 0.05 * limit.kbps);
}

TEST(Frontier, AimingAheadAndTheTimeSpaceLawBothPay) {
  Technique input = tight_full();
  input.model = Model::kInput;
  const Point full = point_of(input);
  Technique no_lead = input;
  no_lead.lead = 0;
  Technique no_time_space = input;
  no_time_space.time_space = 0;
  const Point without_lead = point_of(no_lead);
  EXPECT_GT(without_lead.mean_m, 1.1 * full.mean_m);
  EXPECT_GT(without_lead.kbps, full.kbps);
  EXPECT_GT(point_of(no_time_space).mean_m, 1.1 * full.mean_m);
}

TEST(Frontier, ChoosingTheModelPays) {
  Technique input = tight_full();
  input.model = Model::kInput;
  const Point chosen = point_of(tight_full());
  const Point one = point_of(input);
  std::cout << chosen.mean_m << " m, " << chosen.kbps << " kbit/s; one model " << one.mean_m << " m, " << one.kbps
            << " kbit/s\n";
  EXPECT_LT(chosen.mean_m, one.mean_m);
  EXPECT_LT(chosen.kbps, 0.97 * one.kbps);
}

}  // namespace
}  // namespace padr
