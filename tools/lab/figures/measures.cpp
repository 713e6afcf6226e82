#include "tools/lab/figures/measures.h"

#include <algorithm>

namespace padr::lab::figures {
namespace {

double combined(const trace::InconsistencyPoint& p) {
  return static_cast<double>(p.combined());
}

double mean(const trace::InconsistencySeries& s, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += combined(s[i]);
  return to > from ? sum / static_cast<double>(to - from) : 0;
}

double slope_per_min(const trace::InconsistencySeries& s) {
  const double mean_x = (static_cast<double>(s.size()) - 1) / 2;
  const double mean_y = mean(s, 0, s.size());
  double above = 0;
  double below = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double x = static_cast<double>(i) - mean_x;
    above += x * (combined(s[i]) - mean_y);
    below += x * x;
  }
  return below > 0 ? above / below * kTicksPerSecond * 60 : 0;
}

double longest_above_s(const trace::InconsistencySeries& s, double bound) {
  Tick longest = 0;
  Tick now = 0;
  for (const trace::InconsistencyPoint& p : s) {
    now = combined(p) > bound ? now + 1 : 0;
    longest = std::max(longest, now);
  }
  return static_cast<double>(longest) / kTicksPerSecond;
}

double within(const trace::InconsistencySeries& s, double bound) {
  const auto n = std::count_if(s.begin(), s.end(), [bound](const auto& p) { return combined(p) <= bound; });
  return s.empty() ? 0 : static_cast<double>(n) / static_cast<double>(s.size());
}

double free_within(const FigureRun& run, double bound) {
  std::size_t free = 0;
  std::size_t within = 0;
  for (const trace::InconsistencyPoint& p : run.watched) {
    if (run.touching[static_cast<std::size_t>(p.tick - 1)]) continue;
    ++free;
    if (combined(p) <= bound) ++within;
  }
  return free > 0 ? static_cast<double>(within) / static_cast<double>(free) : 0;
}

}  // namespace

Measures measure(const FigureRun& run, double threshold_high, double tick_way) {
  const trace::InconsistencySeries& s = run.watched;
  Measures m;
  m.combined = trace::summarize(s);
  m.fidelity = trace::summarize(run.fidelity);
  m.pcc = trace::summarize(run.pcc);
  for (const trace::InconsistencyPoint& p : s) {
    m.avatar_peak_m = std::max(m.avatar_peak_m, static_cast<double>(p.avatars_m));
    m.body_peak_m = std::max(m.body_peak_m, static_cast<double>(p.bodies_m));
  }
  for (std::size_t i = 0; i < 3; ++i) m.thirds_m[i] = mean(s, s.size() * i / 3, s.size() * (i + 1) / 3);
  m.trend_m_per_min = slope_per_min(s);
  const auto highest =
      std::max_element(s.begin(), s.end(), [](const auto& a, const auto& b) { return a.combined() < b.combined(); });
  m.peak_touching = highest != s.end() && run.touching[static_cast<std::size_t>(highest->tick - 1)];
  m.free_within_share = free_within(run, threshold_high + tick_way);
  m.within_share = within(s, threshold_high + tick_way);
  m.bodies_off_m = s.empty() ? 0 : static_cast<double>(s.back().bodies_m);
  m.above_longest_s = longest_above_s(s, threshold_high);
  const double seconds = static_cast<double>(run.threshold_m.size()) / kTicksPerSecond;
  m.updates_per_min = static_cast<double>(run.updates) / seconds * 60;
  m.kbps = static_cast<double>(run.wire_bytes) * 8 / 1000 / seconds;
  const auto high = static_cast<float>(threshold_high);
  const auto low = std::count_if(run.threshold_m.begin(), run.threshold_m.end(), [high](float t) { return t < high; });
  m.low_share = static_cast<double>(low) / static_cast<double>(run.threshold_m.size());
  return m;
}

}  // namespace padr::lab::figures
