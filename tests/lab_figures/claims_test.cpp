// The paper's claims on numbers, over several worlds and inputs.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/scenarios/scenarios.h"
#include "tests/seed.h"
#include "tools/lab/figures/claims.h"

namespace padr::lab::figures {
namespace {

constexpr int kCases = 6;

struct Experiment {
  Plan plan;
  Results results;
  std::vector<Claim> claims;
};

const Experiment& experiment() {
  static const Experiment once = [] {
    Experiment e;
    const std::uint64_t first = test::seed(1);
    for (std::uint64_t seed = first; seed < first + kCases; ++seed)
      e.plan.cases.push_back(
          {"wander-" + std::to_string(seed), "", "wander", "wander", seed, scenarios::load_embedded("arena", seed)});
    e.plan.settings = figure_settings();
    e.plan.ticks = 60 * kTicksPerSecond;
    e.results = run_plan(e.plan, {.quiet = true});
    e.claims = judge_claims(e.plan, e.results);
    return e;
  }();
  return once;
}

double mean(const std::string& setting, double (*number)(const Measures&)) {
  return mean_of(over_cases(experiment().plan, experiment().results, setting, number));
}

/// Cases in which one number of one setting is below that of another.
int below(const std::string& setting, const std::string& other, double (*number)(const Measures&)) {
  const std::vector<double> a = over_cases(experiment().plan, experiment().results, setting, number);
  const std::vector<double> b = over_cases(experiment().plan, experiment().results, other, number);
  int n = 0;
  for (std::size_t i = 0; i < a.size(); ++i) n += a[i] < b[i] ? 1 : 0;
  return n;
}

// In single runs the order can be another one: one pile that is pushed for long decides a peak.
void every_claim_but_one_holds_on_average() {
  EXPECT_FALSE(experiment().claims.empty());
  for (const Claim& c : experiment().claims) {
    EXPECT_EQ(c.on_average, c.id != "bounded-with-authority") << c.id << ": " << c.measured;
    EXPECT_GT(c.holds_in, 0) << c.id << ": " << c.measured;
  }
}

void the_ends_of_the_range_differ_in_most_runs() {
  EXPECT_GT(2 * below("fixed-0.3", "fixed-0.8", [](const Measures& m) { return m.combined.peak_m; }), kCases);
  EXPECT_GT(2 * below("fixed-0.8", "fixed-0.3", [](const Measures& m) { return m.updates_per_min; }), kCases);
}

// What a wrong model has set in motion beyond the reach of any contact stays where it went, as nobody owns it and the
// two worlds play it out apart: the time without contact is within the threshold about half the time, not nearly
// always.
void what_no_contact_record_sees_is_not_put_right() {
  for (const char* t : kThresholds) {
    const double share = mean(std::string("fixed-") + t, [](const Measures& m) { return m.free_within_share; });
    EXPECT_LT(share, 0.95) << t;
  }
  EXPECT_GT(mean("full-0.8-0.3", [](const Measures& m) { return m.free_within_share; }), 0.99);
}

void without_authority_it_grows_in_every_run() {
  const auto& claims = experiment().claims;
  const auto growth =
      std::find_if(claims.begin(), claims.end(), [](const Claim& c) { return c.id == "grows-without-authority"; });
  if (growth == claims.end()) FAIL() << "no such claim";
  EXPECT_EQ(growth->holds_in, kCases * static_cast<int>(kThresholds.size()));
  for (const char* t : kThresholds) {
    const auto last = [](const Measures& m) { return m.thirds_m[2]; };
    EXPECT_GT(mean(std::string("avatar-only-") + t, last), 50 * mean(std::string("fixed-") + t, last)) << t;
  }
}

void an_avatar_is_off_by_its_threshold_at_most() {
  // What it moves in the two ticks until the update is there comes on top.
  const double top_speed = static_cast<double>(experiment().plan.cases[0].scene.avatar.max_speed);
  for (const char* t : kThresholds)
    for (const double peak : over_cases(experiment().plan, experiment().results, std::string("fixed-") + t,
                                        [](const Measures& m) { return m.avatar_peak_m; }))
      EXPECT_LE(peak, std::stod(t) + top_speed * 2 / kTicksPerSecond) << t;
}

void adaptive_has_the_body_peaks_of_its_low_threshold() {
  const auto peak = [](const Measures& m) { return m.body_peak_m; };
  const double low = mean("fixed-0.3", peak);
  for (const char* predictor : kPredictors)
    EXPECT_NEAR(mean(adaptive_id(predictor), peak), low, 0.1 * low) << predictor;
}

// The weakness that the paper names, measured: most warnings come true, some do not, and few contacts come unforeseen.
void predictions_are_good_but_not_perfect() {
  for (const char* predictor : kPredictors) {
    const PredictionScore s = score_of(experiment().plan, experiment().results, adaptive_id(predictor));
    EXPECT_GT(s.right + s.wrong, 20 * kCases) << predictor;
    EXPECT_GT(s.foreseen + s.unforeseen, 10 * kCases) << predictor;
    EXPECT_GT(s.precision(), 0.5) << predictor;
    EXPECT_LT(s.precision(), 1) << predictor;
    EXPECT_GT(s.recall(), 0.7) << predictor;
  }
  // Of the predictors of contacts, looking ahead warns for far less of the time than counting bodies does.
  const auto warned = [](const char* predictor) {
    return score_of(experiment().plan, experiment().results, adaptive_id(predictor)).warned_share();
  };
  EXPECT_LT(warned("lookahead"), 0.5 * warned("path-density"));
  EXPECT_LT(warned("lookahead"), 0.5 * warned("density"));
}

void confirmed_worlds_are_the_same() {
  for (const auto& of_case : experiment().results.runs)
    for (const FigureRun& run : of_case) {
      EXPECT_EQ(run.confirmed_mismatches, 0U);
      EXPECT_EQ(run.watched.size(), 60U * kTicksPerSecond) << "every tick is measured";
    }
}

// One test, as every test is a process of its own and the runs are what takes the time.
TEST(Figures, ThePapersClaims) {
  every_claim_but_one_holds_on_average();
  what_no_contact_record_sees_is_not_put_right();
  the_ends_of_the_range_differ_in_most_runs();
  without_authority_it_grows_in_every_run();
  an_avatar_is_off_by_its_threshold_at_most();
  adaptive_has_the_body_peaks_of_its_low_threshold();
  predictions_are_good_but_not_perfect();
  confirmed_worlds_are_the_same();
}

}  // namespace
}  // namespace padr::lab::figures
