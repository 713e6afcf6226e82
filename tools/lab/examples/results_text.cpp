#include <fmt/printf.h>

#include <algorithm>
#include <array>

#include "shell/json.h"
#include "shell/revision.h"
#include "tools/lab/examples/results.h"

namespace padr::lab::examples {
namespace {

using shell::Json;

/// The numbers of a cost, in the one order of every file.
struct Column {
  const char* name;
  double Cost::*value;
};
constexpr std::array<Column, 13> kColumns{{{"pcc_mean_m", &Cost::mean_m},
                                           {"pcc_peak_m", &Cost::peak_m},
                                           {"pcc_final_m", &Cost::final_m},
                                           {"pcc_area_ms", &Cost::area_ms},
                                           {"disturbed_ever", &Cost::ever},
                                           {"disturbed_at_end", &Cost::at_end},
                                           {"untrue_mean_m", &Cost::untrue_mean_m},
                                           {"untrue_final_m", &Cost::untrue_final_m},
                                           {"untrue_at_end", &Cost::untrue_at_end},
                                           {"avatar_mean_m", &Cost::avatar_mean_m},
                                           {"avatar_peak_m", &Cost::avatar_peak_m},
                                           {"updates", &Cost::updates},
                                           {"wire_kbit", &Cost::kbit}}};

std::string headings() {
  std::string s;
  for (const Column& c : kColumns) s += std::string(",") + c.name;
  return s + "\n";
}

std::string fields(const Cost& cost) {
  std::string s;
  for (const Column& c : kColumns) s += fmt::sprintf(",%.6g", cost.*c.value);
  return s + "\n";
}

void put(Json& j, const Cost& cost) {
  for (const Column& c : kColumns) j.field(c.name, cost.*c.value);
}

std::string table_of_rows(const std::vector<RowOfDominoes>& rows) {
  std::string s =
      "\nCost of the model's hit by the number of dominoes: metres in the end, without authority and with it.\n";
  s += "  dominoes  without  of the first domino  disturbed     with\n";
  for (const RowOfDominoes& r : rows) {
    if (r.count > 5 && r.count % 5 != 0) continue;
    const Cost& c = r.without_authority;
    s += fmt::sprintf("  %8d  %7.2f  %19.2f  %9.1f  %7.2f\n", r.count, c.final_m, c.final_by_body_m.front(), c.ever,
                      r.with_authority.final_m);
  }
  const Line line = cost_per_domino(rows);
  return s + fmt::sprintf("  every further domino costs %.2f m (R^2 = %.4f)\n", line.slope_m, line.r_squared);
}

/// What the avatar truly does, over all takes.
std::string what_happens(const Result& story) {
  int touched = 0;
  int hit = 0;
  double nearest = 1e9;
  double farthest = 0;
  for (const Cost& c : story.takes) {
    touched += c.course.touched >= 0 ? 1 : 0;
    hit += c.course.hit >= 0 ? 1 : 0;
    nearest = std::min(nearest, c.course.nearest_m);
    farthest = std::max(farthest, c.course.nearest_m);
  }
  const auto takes = static_cast<int>(story.takes.size());
  if (touched > 0) return fmt::sprintf("  The avatar touches in %d of %d takes.\n", touched, takes);
  return fmt::sprintf(
      "  The avatar touches nothing: it stops %.2f to %.2f m short. Without authority and predictor, its model hits "
      "in\n"
      "  %d of %d takes.\n",
      nearest, farthest, hit, takes);
}

/// What predictors were worth in one story.
std::string table_of_verdicts(const std::vector<Verdict>& verdicts, const std::string& story) {
  std::string s =
      "  Each predictor, avatar-only, against no predictor:\n"
      "  predictor     warned before  s before  model hits  contacts foreseen  cost (m)  avoided (m)\n";
  for (const Verdict& v : verdicts) {
    if (v.story != story) continue;
    const std::string lead = v.warned > 0 ? fmt::sprintf("%.2f", v.lead_s) : "-";
    const std::string foreseen = v.contacts > 0 ? fmt::sprintf("%d of %d", v.foreseen, v.contacts) : "-";
    s += fmt::sprintf("  %-12s %9d of %-2d %8s %6d of %-2d %17s %9.2f %12.2f\n", v.predictor.c_str(), v.warned, v.takes,
                      lead.c_str(), v.hits, v.takes, foreseen.c_str(), v.cost_m, v.avoided_m);
  }
  for (const Verdict& v : verdicts)
    if (v.story == story) s += "  " + v.predictor + ": " + v.sentence + "\n";
  return s;
}

void put(Json& j, const Verdict& v) {
  j.begin_object().field("story", v.story).field("predictor", v.predictor).field("takes", v.takes);
  j.field("warned", v.warned).field("lead_s", v.lead_s).field("hits", v.hits).field("contacts", v.contacts);
  j.field("foreseen", v.foreseen).field("cost_m", v.cost_m).field("avoided_m", v.avoided_m);
  j.field("sentence", v.sentence).end_object();
}

}  // namespace

std::string table(const Results& r, const Plan& plan) {
  std::string s = fmt::sprintf(
      "Physics-consistency cost: error of bodies in the other peer's view, caused by the model of\n"
      "one avatar. Means of %d takes of each story; netem \"%s\".\n",
      plan.takes, plan.netem_text.c_str());
  const std::size_t variants = r.results.empty() ? 1 : r.results.size() / plan.stories.size();
  for (std::size_t i = 0; i < r.results.size(); ++i) {
    const Result& one = r.results[i];
    if (i % variants == 0) {
      s += fmt::sprintf("\n%s: %s\n", one.story.c_str(), story_by_name(one.story).title.c_str()) + what_happens(one);
      s += "                                    bodies off (m)         > 5 cm off   untrue in\n";
      s += "  technique                     mean   peak  in the end   ever  at end    the end  updates   kbit\n";
    }
    const Cost& c = one.mean;
    s += fmt::sprintf("  %-27s %6.3f %6.2f %11.2f %6.1f %7.1f %10.2f %8.1f %6.1f\n", one.variant.label.c_str(),
                      c.mean_m, c.peak_m, c.final_m, c.ever, c.at_end, c.untrue_final_m, c.updates, c.kbit);
    if (i % variants == variants - 1) s += table_of_verdicts(r.verdicts, one.story);
  }
  if (!r.rows.empty()) s += table_of_rows(r.rows);
  return s +
         "\navoided: the part of the cost without a predictor that this predictor avoided.\n"
         "untrue: error against a run in which the same input plays alone, because two views can agree on an event\n"
         "that never would have happened. Below 5 mm everything is noise.\n";
}

std::string csv(const Results& r) {
  std::string s = "story,bodies,technique,takes" + headings();
  for (const Result& one : r.results)
    s += one.story + fmt::sprintf(",%zu,", one.bodies) + one.variant.flags + fmt::sprintf(",%zu", one.takes.size()) +
         fields(one.mean);
  return s;
}

std::string verdicts_csv(const Results& r) {
  std::string s = "story,predictor,takes,warned,lead_s,hits,contacts,foreseen,cost_m,avoided_m\n";
  for (const Verdict& v : r.verdicts)
    s += v.story + "," + v.predictor +
         fmt::sprintf(",%d,%d,%.6g,%d,%d,%d,%.6g,%.6g\n", v.takes, v.warned, v.lead_s, v.hits, v.contacts, v.foreseen,
                      v.cost_m, v.avoided_m);
  return s;
}

std::string takes_csv(const Results& r) {
  std::string s = "story,bodies,technique,take" + headings();
  for (const Result& one : r.results)
    for (std::size_t t = 0; t < one.takes.size(); ++t)
      s += one.story + fmt::sprintf(",%zu,", one.bodies) + one.variant.flags + fmt::sprintf(",%zu", t) +
           fields(one.takes[t]);
  return s;
}

std::string json(const Results& r, const Plan& plan, const std::string& command) {
  Json j;
  j.begin_object().field("program", "padr-lab examples").field("revision", shell::revision());
  j.field("command", command).field("takes", plan.takes).field("netem", plan.netem_text);
  j.field("disturbed_above_m", static_cast<double>(kDisturbedMetres));
  j.key("results").begin_array();
  for (const Result& one : r.results) {
    j.begin_object().field("story", one.story).field("bodies", one.bodies).field("technique", one.variant.flags);
    put(j, one.mean);
    j.end_object();
  }
  j.end_array().key("predictors").begin_array();
  for (const Verdict& v : r.verdicts) put(j, v);
  j.end_array();
  if (!r.rows.empty()) {
    const Line line = cost_per_domino(r.rows);
    j.key("dominoes").begin_object().field("metres_per_domino", line.slope_m).field("r_squared", line.r_squared);
    j.key("rows").begin_array();
    for (const RowOfDominoes& row : r.rows) {
      j.begin_object().field("dominoes", row.count);
      j.key("without_authority").begin_object();
      put(j, row.without_authority);
      j.end_object().key("with_authority").begin_object();
      put(j, row.with_authority);
      j.end_object().key("final_by_domino_m").begin_array();
      for (const double m : row.without_authority.final_by_body_m) j.value(m);
      j.end_array().end_object();
    }
    j.end_array().end_object();
  }
  return j.end_object().text();
}

plot::LinePlot dominoes_plot(const Results& r) {
  plot::LinePlot p;
  p.name = "dominoes";
  p.title = "What hitting the first domino costs";
  p.x.label = "dominoes in the row";
  p.x.from = 0;
  plot::Line without{.title = "without authority", .look = plot::look_of("avatar-only")};
  plot::Line with{.title = "with authority", .look = plot::look_of("adaptive")};
  plot::Line first{.title = "dominoes times the cost of the first", .look = {plot::shade(2), 1, 7}};
  for (const RowOfDominoes& row : r.rows) {
    const auto n = static_cast<double>(row.count);
    without.points.push_back({n, row.without_authority.final_m});
    with.points.push_back({n, row.with_authority.final_m});
    first.points.push_back({n, n * row.without_authority.final_by_body_m.front()});
  }
  plot::Panel panel;
  panel.y.label = "bodies off in the end (m)";
  panel.y.from = 0;
  panel.lines = {first, without, with};
  p.panels.push_back(panel);
  return p;
}

}  // namespace padr::lab::examples
