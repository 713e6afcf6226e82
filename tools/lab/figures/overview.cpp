#include <algorithm>

#include "tools/lab/figures/pictures.h"

// The pictures of all cases together.
namespace padr::lab::figures {
namespace {

constexpr std::size_t kSlice = kTicksPerSecond;  // the mean of one second is one point

struct Band {
  std::vector<plot::Point> mean;
  std::vector<plot::Spread::Slice> range;
};

Band band_of(const Results& r, std::size_t setting) {
  Band band;
  std::size_t longest = 0;
  for (const std::vector<FigureRun>& of_case : r.runs) longest = std::max(longest, of_case[setting].watched.size());
  const std::size_t slices = longest / kSlice;
  for (std::size_t i = 0; i < slices; ++i) {
    double sum = 0;
    double low = 1e300;
    double high = 0;
    double cases = 0;
    for (const std::vector<FigureRun>& of_case : r.runs) {
      const trace::InconsistencySeries& s = of_case[setting].watched;
      const std::size_t end = std::min((i + 1) * kSlice, s.size());
      if (end <= i * kSlice) continue;  // its worlds were not confirmed so far
      double mean = 0;
      for (std::size_t t = i * kSlice; t < end; ++t)
        mean += static_cast<double>(s[t].combined()) / static_cast<double>(end - i * kSlice);
      ++cases;
      sum += mean;
      low = std::min(low, mean);
      high = std::max(high, mean);
    }
    const double x = static_cast<double>(i) + 0.5;
    const double mean = sum / cases;
    // A logarithmic scale has no zero; and below this all is noise.
    const auto shown = [](double v) { return std::max(v, trace::kNoiseMetres); };
    band.mean.push_back({x, shown(mean)});
    band.range.push_back({x, shown(low), shown(high)});
  }
  return band;
}

plot::Mark mark_of(const Plan& plan, const Results& r, const std::string& id, const std::string& label) {
  return {mean_of(over_cases(plan, r, id, [](const Measures& m) { return m.updates_per_min; })),
          mean_of(over_cases(plan, r, id, [](const Measures& m) { return m.combined.peak_m; })), label};
}

}  // namespace

plot::LinePlot drift(const Plan& plan, const Results& r) {
  plot::LinePlot p{.name = "drift",
                   .title = "Mean of all cases, and their range",
                   .x = {.label = "session time (s)", .from = 0, .to = plan.seconds()}};
  plot::Panel panel{.y = {.label = "combined inconsistency (m)", .log = true, .from = trace::kNoiseMetres}};
  for (const std::string& id : {std::string("avatar-only-0.3"), std::string("fixed-0.3"), adaptive_id(kPredictors[0]),
                                std::string("full-0.8-0.3")}) {
    const std::size_t k = setting_index(plan.settings, id);
    const plot::Look look = plot::look_of(plan.settings[k].title);
    Band band = band_of(r, k);
    if (plan.cases.size() > 1) panel.spreads.push_back({.look = look, .slices = std::move(band.range)});
    panel.lines.push_back({.title = plan.settings[k].title.substr(0, plan.settings[k].title.find(',')),
                           .look = look,
                           .points = std::move(band.mean),
                           .width = 2.2});
  }
  p.panels.push_back(std::move(panel));
  return p;
}

plot::ScatterPlot peaks(const Plan& plan, const Results& r) {
  plot::ScatterPlot p{.name = "peaks",
                      .title = "What peaks cost: means of all cases",
                      .x = {.label = "entity updates per minute", .from = 0},
                      .y = {.label = "peak of combined inconsistency (m)", .log = true}};
  for (const std::string name : {"avatar-only", "fixed"}) {
    plot::MarkSeries s{.title = name, .look = plot::look_of(name), .joined = true};
    for (const char* t : kThresholds) s.marks.push_back(mark_of(plan, r, name + "-" + t, std::string(t) + " m"));
    p.series.push_back(std::move(s));
  }
  p.series.push_back({.title = "adaptive 0.8:0.3 m",
                      .look = plot::look_of("adaptive"),
                      .marks = {mark_of(plan, r, adaptive_id(kPredictors[0]), "")}});
  p.series.push_back(
      {.title = "full 0.8:0.3 m", .look = plot::look_of("full"), .marks = {mark_of(plan, r, "full-0.8-0.3", "")}});
  return p;
}

plot::BarPlot predictors(const Plan& plan, const Results& r) {
  plot::BarPlot p{.name = "prediction",
                  .title = "Predictions of contacts by adaptive 0.8:0.3 m, all cases",
                  .y = {.label = "share", .from = 0, .to = 1.2},
                  .label_digits = 2};
  plot::BarSeries right{.title = "warnings that came true", .look = {.colour = plot::shade(1)}};
  plot::BarSeries foreseen{.title = "contacts foreseen", .look = {.colour = plot::shade(2)}};
  plot::BarSeries warned{.title = "free time under warning", .look = {.colour = plot::shade(3)}};
  for (const char* predictor : kPredictors) {
    const PredictionScore s = score_of(plan, r, adaptive_id(predictor));
    p.groups.emplace_back(predictor);
    right.values.push_back(s.precision());
    foreseen.values.push_back(s.recall());
    warned.values.push_back(s.warned_share());
  }
  p.series = {right, foreseen, warned};
  return p;
}

}  // namespace padr::lab::figures
