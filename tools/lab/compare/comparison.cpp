#include "tools/lab/compare/comparison.h"

#include <fmt/printf.h>

#include <algorithm>
#include <cmath>

#include "tools/lab/simulation.h"
#include "tools/lab/unmeasured.h"

namespace padr::lab::compare {

Figure Row::over(double (*field)(const Score&), bool (*has)(const Score&)) const {
  std::vector<double> values;
  for (const Score& s : scores)
    if (has(s)) values.push_back(field(s));
  Figure f;
  if (values.empty()) return f;
  f.low = *std::min_element(values.begin(), values.end());
  f.high = *std::max_element(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  for (const double v : values) f.mean += v / n;
  double squares = 0;
  for (const double v : values) squares += (v - f.mean) * (v - f.mean);
  if (n > 1) f.error = std::sqrt(squares / (n - 1) / n);
  return f;
}

double Row::mean_m() const {
  return over([](const Score& s) { return s.off.mean_m; }).mean;
}

double Row::kbps() const {
  return over([](const Score& s) { return s.kbps; }).mean;
}

std::optional<double> Row::processor_steps() const {
  if (scores.empty() || !scores.front().processor_steps) return std::nullopt;
  return over([](const Score& s) { return s.processor_steps.value_or(0); }).mean;
}

std::vector<Row> run_plan(const Plan& plan) {
  const std::size_t seeds = plan.seeds.size();
  const std::size_t of_network = plan.contestants.size() * seeds;
  const auto job = [&plan, seeds, of_network](std::size_t i) {
    return run_trial(plan.contestants[i % of_network / seeds], plan.networks[i / of_network], plan.setting,
                     plan.seeds[i % seeds]);
  };
  const std::vector<Score> scores = parallel_results<Score>(plan.networks.size() * of_network, job, plan.parallel);
  std::vector<Row> rows;
  auto next = scores.begin();
  for (const Network& n : plan.networks) {
    for (const Contestant& c : plan.contestants) {
      rows.push_back({c, n.text, {next, next + static_cast<std::ptrdiff_t>(seeds)}});
      next += static_cast<std::ptrdiff_t>(seeds);
    }
  }
  return rows;
}

namespace {

double measured_share(const Row& row) {
  return row.over([](const Score& s) { return s.measured_share; }).mean;
}

}  // namespace

void warn_of_unmeasured(const std::vector<Row>& rows, Tick ticks) {
  for (const Row& r : rows) lab::warn_of_unmeasured(r.who.id + ", netem '" + r.network + "'", measured_share(r), ticks);
}

std::string little_measured(const std::vector<Row>& rows, const std::string& network, Tick ticks) {
  std::string list;
  for (const Row& r : rows) {
    const double share = measured_share(r);
    if (r.network == network && Simulation::is_little(share, ticks))
      list += (list.empty() ? "" : ", ") + r.who.id + fmt::sprintf(" (%.0f %%)", 100 * share);
  }
  return list.empty() ? ""
                      : "Few ticks were confirmed in time, so only these were measured: " + list +
                            ". Do not compare these figures.";
}

Standing standing(const Row& row, const std::vector<Row>& rows) {
  if (row.who.id == "full") return Standing::kIsFull;
  const auto full = std::find_if(rows.begin(), rows.end(),
                                 [&row](const Row& r) { return r.who.id == "full" && r.network == row.network; });
  if (full == rows.end()) return Standing::kNoFull;
  const bool less_off = row.mean_m() < full->mean_m();
  const bool less_traffic = row.kbps() < full->kbps();
  if (less_off && less_traffic) return Standing::kDominates;
  return less_off || less_traffic ? Standing::kTrades : Standing::kWorse;
}

std::optional<double> full_for_no_more(const Row& row, const std::vector<Row>& rows) {
  std::optional<double> least;
  for (const Row& r : rows) {
    if (r.network != row.network || !is_budget_of_full(r.who) || r.kbps() > row.kbps()) continue;
    least = std::min(least.value_or(r.mean_m()), r.mean_m());
  }
  return least;
}

}  // namespace padr::lab::compare
