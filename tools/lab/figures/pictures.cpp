#include "tools/lab/figures/pictures.h"

#include <algorithm>

namespace padr::lab::figures {
namespace {

constexpr int kMostPoints = 1200;       // along the time axis; more are not seen
constexpr double kLeastStretch = 0.15;  // s; what is shorter is not seen

double seconds(std::size_t tick) {
  return static_cast<double>(tick) / kTicksPerSecond;
}

double combined_of(const trace::InconsistencyPoint& p) {
  return static_cast<double>(p.combined());
}
double avatars_of(const trace::InconsistencyPoint& p) {
  return static_cast<double>(p.avatars_m);
}

/// Of so many ticks as fit one point the highest, so that no peak is lost.
std::vector<plot::Point> curve(const FigureRun& run, double (*value)(const trace::InconsistencyPoint&) = combined_of) {
  const std::size_t width = run.watched.size() / kMostPoints + 1;
  std::vector<plot::Point> points;
  for (std::size_t from = 0; from < run.watched.size(); from += width) {
    double highest = 0;
    for (std::size_t i = from; i < std::min(from + width, run.watched.size()); ++i)
      highest = std::max(highest, value(run.watched[i]));
    points.push_back({seconds(from + 1), highest});
  }
  return points;
}

plot::Line line_of(const Plan& plan, const Results& r, std::size_t of_case, const std::string& id, int variant = 0) {
  const std::size_t k = setting_index(plan.settings, id);
  const Setting& s = plan.settings[k];
  // The predictor in the setting's title is the one that the technique has by itself.
  return {.title = s.title.substr(0, s.title.find(',')),
          .look = plot::look_of(s.title, variant),
          .points = curve(r.runs[of_case][k]),
          .width = 1.8};
}

plot::Axis time_axis(const Plan& plan) {
  return {.label = "session time (s)", .from = 0, .to = plan.seconds()};
}

plot::Line threshold_line(const std::string& title, std::vector<plot::Point> points) {
  return {.title = title, .look = {.colour = plot::shade(0)}, .points = std::move(points), .steps = true, .width = 1.6};
}

/// The same for all pictures of a case in which there is authority, so that they can be compared.
plot::Axis metres(const Plan& plan, const Results& r, std::size_t of_case) {
  double highest = 0;
  for (const char* t : kThresholds)
    highest =
        std::max(highest, r.measures[of_case][setting_index(plan.settings, std::string("fixed-") + t)].combined.peak_m);
  highest =
      std::max(highest, r.measures[of_case][setting_index(plan.settings, adaptive_id(kPredictors[0]))].combined.peak_m);
  // A sawtooth of 0.3 m is to be seen beside a peak of 5 m.
  return {.label = "combined (m), root scale", .root = true, .from = 0, .to = highest * 1.05};
}

/// The sawtooth of the paper's figures, which bodies that are off hide.
plot::Line avatars_line(const Plan& plan, const Results& r, std::size_t of_case, const std::string& id) {
  return {.title = "avatar alone",
          .look = {.colour = plot::shade(2)},
          .points = curve(r.runs[of_case][setting_index(plan.settings, id)], avatars_of),
          .width = 1.2};
}

plot::Shading contacts_of(const FigureRun& run) {
  plot::Shading s{.title = "avatar touches a body", .colour = plot::shade(3)};
  for (std::size_t t = 0; t < run.touching.size(); ++t) {
    if (!run.touching[t]) continue;
    const double from = seconds(t + 1);
    if (!s.stretches.empty() && from <= s.stretches.back().to) {
      s.stretches.back().to = std::max(s.stretches.back().to, from + seconds(1));
    } else {
      s.stretches.push_back({from, from + kLeastStretch});
    }
  }
  return s;
}

std::vector<plot::Point> thresholds_of(const FigureRun& run) {
  std::vector<plot::Point> points;
  for (std::size_t t = 0; t < run.threshold_m.size(); ++t) {
    const auto now = static_cast<double>(run.threshold_m[t]);
    if (points.empty() || points.back().y != now || t + 1 == run.threshold_m.size())
      points.push_back({seconds(t + 1), now});
  }
  return points;
}

}  // namespace

plot::LinePlot figure7(const Plan& plan, const Results& r, std::size_t of_case) {
  plot::LinePlot p{.name = "figure7-" + plan.cases[of_case].id,
                   .title = "No authority over bodies: " + plan.cases[of_case].title,
                   .x = time_axis(plan)};
  plot::Panel panel{.y = {.label = "combined inconsistency (m)", .from = 0}};
  int variant = 0;
  for (const char* t : kThresholds)
    panel.lines.push_back(line_of(plan, r, of_case, std::string("avatar-only-") + t, variant++));
  p.panels.push_back(std::move(panel));
  return p;
}

plot::LinePlot figure8(const Plan& plan, const Results& r, std::size_t of_case) {
  plot::LinePlot p{.name = "figure8-" + plan.cases[of_case].id,
                   .title = "Dynamic authority, fixed thresholds: " + plan.cases[of_case].title,
                   .x = time_axis(plan)};
  for (const char* t : kThresholds) {
    plot::Panel panel{.y = metres(plan, r, of_case)};
    panel.lines.push_back(avatars_line(plan, r, of_case, std::string("fixed-") + t));
    panel.lines.push_back(line_of(plan, r, of_case, std::string("fixed-") + t));
    panel.lines.push_back(threshold_line("threshold", {{0, std::stod(t)}, {plan.seconds(), std::stod(t)}}));
    p.panels.push_back(std::move(panel));
  }
  return p;
}

plot::LinePlot figure9(const Plan& plan, const Results& r, std::size_t of_case) {
  plot::LinePlot p{.name = "figure9-" + plan.cases[of_case].id,
                   .title = "Dynamic authority, adaptive threshold: " + plan.cases[of_case].title,
                   .x = time_axis(plan)};
  const std::string id = adaptive_id(kPredictors[0]);
  const FigureRun& run = r.runs[of_case][setting_index(plan.settings, id)];
  plot::Panel adaptive{.y = metres(plan, r, of_case)};
  adaptive.lines.push_back(avatars_line(plan, r, of_case, id));
  adaptive.lines.push_back(line_of(plan, r, of_case, id));
  plot::Panel in_force{.y = {.label = "threshold (m)", .from = 0, .to = 1}};
  in_force.lines.push_back(threshold_line("threshold in force", thresholds_of(run)));
  in_force.shadings.push_back(contacts_of(run));
  adaptive.shadings.push_back(contacts_of(run));
  adaptive.shadings.back().title.clear();
  plot::Panel tight{.y = metres(plan, r, of_case)};
  tight.lines.push_back(avatars_line(plan, r, of_case, "fixed-0.3"));
  tight.lines.push_back(line_of(plan, r, of_case, "fixed-0.3"));
  tight.lines.back().title += ", to compare";
  p.panels = {std::move(in_force), std::move(adaptive), std::move(tight)};
  return p;
}

std::string draw_pictures(const std::string& dir, const Plan& plan, const Results& r, const ParallelOptions& parallel) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name, const std::vector<plot::NamedText>& files) {
    plot::write_into("--out", dir, files);
    names.push_back(name);
  };
  const auto add_plot = [&](const auto& picture) { add(picture.name, plot::files(picture)); };
  const std::size_t shown = setting_index(plan.settings, "fixed-0.3");
  for (std::size_t c = 0; c < plan.cases.size(); ++c) {
    add("figure6-" + plan.cases[c].id, path_picture(plan.cases[c], r.runs[c][shown]));
    add_plot(figure7(plan, r, c));
    add_plot(figure8(plan, r, c));
    add_plot(figure9(plan, r, c));
  }
  add_plot(drift(plan, r));
  add_plot(peaks(plan, r));
  add_plot(predictors(plan, r));
  ParallelOptions options = parallel;
  options.what = "pictures";
  const std::vector<std::string> errors = parallel_results<std::string>(
      names.size(), [&](std::size_t i) { return plot::draw(dir, {names[i]}).wrong; }, options);
  const auto first = std::find_if(errors.begin(), errors.end(), [](const std::string& e) { return !e.empty(); });
  return first == errors.end() ? "" : *first;
}

}  // namespace padr::lab::figures
