#include "tools/lab/figures/experiment.h"

#include <algorithm>
#include <numeric>

namespace padr::lab::figures {

Results run_plan(const Plan& plan, const ParallelOptions& parallel) {
  const std::size_t settings = plan.settings.size();
  std::vector<FigureRun> all = parallel_results<FigureRun>(
      plan.cases.size() * settings,
      [&](std::size_t i) {
        return run_figure(plan.cases[i / settings], plan.settings[i % settings], plan.netem, plan.ticks);
      },
      parallel);
  Results r;
  r.runs.resize(plan.cases.size());
  r.measures.resize(plan.cases.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Setting& s = plan.settings[i % settings];
    const float way = plan.cases[i / settings].scene.avatar.max_speed * kTickSeconds;
    r.measures[i / settings].push_back(
        measure(all[i], static_cast<double>(s.technique.threshold_high), static_cast<double>(way)));
    r.runs[i / settings].push_back(std::move(all[i]));
  }
  return r;
}

std::vector<std::string> kinds_of(const Plan& plan) {
  std::vector<std::string> kinds;
  for (const Case& c : plan.cases)
    if (std::find(kinds.begin(), kinds.end(), c.kind) == kinds.end()) kinds.push_back(c.kind);
  return kinds;
}

std::vector<double> over_cases(const Plan& plan, const Results& results, const std::string& setting,
                               double (*number)(const Measures&), const std::string& kind) {
  const std::size_t s = setting_index(plan.settings, setting);
  std::vector<double> values;
  for (std::size_t c = 0; c < results.measures.size(); ++c)
    if (kind.empty() || plan.cases[c].kind == kind) values.push_back(number(results.measures[c][s]));
  return values;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

PredictionScore score_of(const Plan& plan, const Results& results, const std::string& setting) {
  const std::size_t s = setting_index(plan.settings, setting);
  PredictionScore sum;
  for (const std::vector<FigureRun>& of_case : results.runs) sum += of_case[s].score;
  return sum;
}

}  // namespace padr::lab::figures
