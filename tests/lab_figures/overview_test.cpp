// The pictures of all cases together.
#include <gtest/gtest.h>

#include "tools/lab/figures/pictures.h"

namespace padr::lab::figures {
namespace {

trace::InconsistencySeries series(Tick ticks, float metres) {
  trace::InconsistencySeries s;
  for (Tick t = 1; t <= ticks; ++t) s.push_back({t, metres});
  return s;
}

// Once, they were 0 m, and all was as long as the first case.
TEST(Drift, SecondsThatWereNotMeasuredDoNotCount) {
  Plan plan;
  plan.settings = figure_settings();
  plan.ticks = 3 * kTicksPerSecond;
  plan.cases.resize(3);
  Results results;
  for (const auto& watched :
       {series(kTicksPerSecond, 0.5F), series(3 * kTicksPerSecond, 1), series(3 * kTicksPerSecond / 2, 3)}) {
    FigureRun run;
    run.watched = watched;
    results.runs.emplace_back(plan.settings.size(), run);
  }
  const plot::Panel panel = drift(plan, results).panels.at(0);
  ASSERT_EQ(panel.lines.at(0).points.size(), 3U);
  const double means[] = {1.5, 2, 1};
  const double lows[] = {0.5, 1, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(panel.lines[0].points[i].y, means[i], 1e-6) << "second " << i;
    EXPECT_NEAR(panel.spreads.at(0).slices.at(i).low, lows[i], 1e-6) << "second " << i;
  }
}

}  // namespace
}  // namespace padr::lab::figures
