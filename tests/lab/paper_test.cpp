// What the paper claims, asserted on numbers of the same kind as its figures.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/lab/session.h"
#include "tests/seed.h"

namespace padr {
namespace {

Technique fixed(float threshold) {
  Technique t = technique_by_name("fixed");
  t.threshold_high = t.threshold_low = threshold;
  return t;
}

/// Mean of the combined inconsistency over the ticks of one third of the run, m.
double third(const trace::InconsistencyMeter& meter, int which) {
  double sum = 0;
  std::size_t n = 0;
  for (PeerId p = 0; p < 2; ++p) {
    const auto& series = meter.series(p);
    const std::size_t from = series.size() * static_cast<std::size_t>(which) / 3;
    const std::size_t to = series.size() * static_cast<std::size_t>(which + 1) / 3;
    for (std::size_t i = from; i < to; ++i) sum += static_cast<double>(series[i].combined());
    n += to - from;
  }
  return sum / static_cast<double>(n);
}

TEST(Paper, WithoutAuthorityInconsistencyGrowsWithItDoesNot) {
  const std::uint64_t seed = test::seed(3);
  test::Session none("arena", 2, technique_by_name("avatar-only"), "", seed, 60);
  none.simulation->run();
  test::Session dynamic("arena", 2, fixed(0.5F), "", seed, 60);
  dynamic.simulation->run();
  const auto& without = none.simulation->meter();
  const auto& with = dynamic.simulation->meter();
  EXPECT_GT(third(without, 1), 1.3 * third(without, 0));
  EXPECT_GT(third(without, 2), 1.3 * third(without, 1));
  EXPECT_LT(third(with, 2), 2.0);
  EXPECT_GT(third(without, 2), 10 * third(with, 2));
}

TEST(Paper, TighterThresholdsGiveSmallerErrorsAndMoreUpdates) {
  const std::uint64_t seed = test::seed(3);
  double last_mean = 1e9;
  std::uint64_t last_updates = 0;
  for (const float threshold : {0.8F, 0.5F, 0.3F}) {
    test::Session s("arena", 2, fixed(threshold), "", seed, 60);
    s.simulation->run();
    const double mean = s.simulation->meter().overall().avatar_mean_m;
    std::uint64_t updates = 0;
    for (PeerId p = 0; p < 2; ++p)
      updates += s.simulation->replica(p).stats().updates_by_cause[static_cast<std::size_t>(sync::Cause::kThreshold)];
    EXPECT_LT(mean, last_mean) << threshold;
    EXPECT_GT(updates, last_updates) << threshold;
    last_mean = mean;
    last_updates = updates;
  }
}

// Nothing is lost or late: in no view and at no tick does an avatar's error exceed the threshold by more than the way
// of two ticks.
TEST(Paper, WithoutImpairmentAvatarsStayWithinTheirThreshold) {
  for (const char* name : {"fixed", "full"}) {
    Technique t = technique_by_name(name);
    test::Session s("arena", 2, t, "", test::seed(5), 40);
    s.simulation->run();
    for (PeerId p = 0; p < 2; ++p) {
      float worst = 0;
      // One tick of way is the least a datagram takes: that much motion comes on top.
      for (const auto& point : s.simulation->meter().series(p)) worst = std::max(worst, point.avatars_m);
      EXPECT_LE(worst, t.threshold_high + s.scene.avatar.max_speed * 2 * kTickSeconds) << name;
    }
  }
}

}  // namespace
}  // namespace padr
