#include "tools/lab/figures/results_text.h"

#include <algorithm>
#include <array>

#include "shell/json.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "tools/lab/figures/words.h"

namespace padr::lab::figures {
namespace {

using plot::number;
using shell::Json;

/// The numbers of a run, in the one order of every file.
struct Column {
  const char* name;
  double (*value)(const Measures&);
};
constexpr std::array<Column, 26> kColumns{{
    {"mean_m", [](const Measures& m) { return m.combined.mean_m; }},
    {"avatar_mean_m", [](const Measures& m) { return m.combined.avatar_mean_m; }},
    {"body_mean_m", [](const Measures& m) { return m.combined.body_mean_m; }},
    {"p95_m", [](const Measures& m) { return m.combined.p95_m; }},
    {"p99_m", [](const Measures& m) { return m.combined.p99_m; }},
    {"peak_m", [](const Measures& m) { return m.combined.peak_m; }},
    {"avatar_peak_m", [](const Measures& m) { return m.avatar_peak_m; }},
    {"body_peak_m", [](const Measures& m) { return m.body_peak_m; }},
    {"first_third_mean_m", [](const Measures& m) { return m.thirds_m[0]; }},
    {"second_third_mean_m", [](const Measures& m) { return m.thirds_m[1]; }},
    {"last_third_mean_m", [](const Measures& m) { return m.thirds_m[2]; }},
    {"trend_m_per_min", [](const Measures& m) { return m.trend_m_per_min; }},
    {"bodies_at_end_m", [](const Measures& m) { return m.bodies_off_m; }},
    {"longest_above_threshold_s", [](const Measures& m) { return m.above_longest_s; }},
    {"updates_per_min", [](const Measures& m) { return m.updates_per_min; }},
    {"wire_kbps", [](const Measures& m) { return m.kbps; }},
    {"free_ticks_within_threshold_share", [](const Measures& m) { return m.free_within_share; }},
    {"ticks_within_threshold_share", [](const Measures& m) { return m.within_share; }},
    {"low_threshold_share", [](const Measures& m) { return m.low_share; }},
    {"fidelity_mean_m", [](const Measures& m) { return m.fidelity.mean_m; }},
    {"fidelity_others_mean_m", [](const Measures& m) { return m.fidelity.others_mean_m; }},
    {"fidelity_nobody_mean_m", [](const Measures& m) { return m.fidelity.nobody_mean_m; }},
    {"fidelity_peak_m", [](const Measures& m) { return m.fidelity.peak_m; }},
    {"pcc_mean_m", [](const Measures& m) { return m.pcc.mean_m; }},
    {"pcc_peak_m", [](const Measures& m) { return m.pcc.peak_m; }},
    {"pcc_bodies_mean", [](const Measures& m) { return m.pcc.bodies_mean; }},
}};

void put(Json& j, const PredictionScore& s) {
  j.field("precision", s.precision()).field("recall", s.recall());
  j.field("warnings_right", s.right).field("warnings_wrong", s.wrong);
  j.field("contacts_foreseen", s.foreseen).field("contacts_unforeseen", s.unforeseen);
  j.field("warned_share_of_free_time", s.warned_share()).field("lead_s", s.lead_s());
}

void put_run(Json& j, const FigureRun& run, const Measures& m) {
  for (const Column& c : kColumns) j.field(c.name, c.value(m));
  j.key("updates_by_cause").begin_object();
  for (std::size_t c = 0; c < sync::kCauses; ++c) j.field(sync::kCauseNames[c], run.updates_by_cause[c]);
  j.end_object().field("datagrams", run.datagrams).field("confirmed_mismatches", run.confirmed_mismatches);
}

std::string runs_csv(const Plan& plan, const Results& r) {
  std::string s = "case,setting";
  for (const Column& c : kColumns) s += std::string(",") + c.name;
  for (const std::string_view cause : sync::kCauseNames) s += ",updates_" + std::string(cause);
  s += ",datagrams\n";
  for (std::size_t c = 0; c < plan.cases.size(); ++c) {
    for (std::size_t k = 0; k < plan.settings.size(); ++k) {
      s += plan.cases[c].id + "," + plan.settings[k].id;
      for (const Column& column : kColumns) s += "," + number(column.value(r.measures[c][k]));
      for (const std::uint64_t n : r.runs[c][k].updates_by_cause) s += "," + std::to_string(n);
      s += "," + std::to_string(r.runs[c][k].datagrams) + "\n";
    }
  }
  return s;
}

std::string predictors_csv(const Plan& plan, const Results& r) {
  std::string s =
      "case,predictor,precision,recall,warnings_right,warnings_wrong,contacts_foreseen,contacts_unforeseen,"
      "warned_share_of_free_time,lead_s\n";
  const auto row = [&s](const std::string& name, const char* predictor, const PredictionScore& p) {
    s += name + "," + predictor + "," + number(p.precision()) + "," + number(p.recall());
    for (const int n : {p.right, p.wrong, p.foreseen, p.unforeseen}) s += "," + std::to_string(n);
    s += "," + number(p.warned_share()) + "," + number(p.lead_s()) + "\n";
  };
  for (const char* predictor : kPredictors) {
    const std::string id = adaptive_id(predictor);
    const std::size_t k = setting_index(plan.settings, id);
    for (std::size_t c = 0; c < plan.cases.size(); ++c) row(plan.cases[c].id, predictor, r.runs[c][k].score);
    row("all", predictor, score_of(plan, r, id));
  }
  return s;
}

std::string series_csv(const Plan& plan, const std::vector<FigureRun>& runs) {
  const std::size_t adaptive = setting_index(plan.settings, adaptive_id(kPredictors[0]));
  std::string s = "tick,seconds";
  for (const Setting& setting : plan.settings) s += "," + setting.id + "_m";
  s += ",adaptive_threshold_m,adaptive_touching\n";
  for (std::size_t t = 0; t < static_cast<std::size_t>(plan.ticks); ++t) {
    s += std::to_string(t + 1) + "," + number(static_cast<double>(t + 1) / kTicksPerSecond, 6);
    for (const FigureRun& run : runs)
      s += "," + (t < run.watched.size() ? number(static_cast<double>(run.watched[t].combined()), 5) : "?");
    s += "," + number(static_cast<double>(runs[adaptive].threshold_m[t]), 4);
    s += runs[adaptive].touching[t] ? ",1\n" : ",0\n";
  }
  return s;
}

std::string padded(std::string text, std::size_t width) {
  // Titles are plain ASCII.
  text.resize(std::max(text.size(), width), ' ');
  return text;
}

std::string right(const std::string& text, std::size_t width) {
  return std::string(width > text.size() ? width - text.size() : 0, ' ') + text;
}

}  // namespace

std::string table(const Plan& plan, const Results& r, const std::vector<Claim>& claims) {
  std::string s = plan.scenario + ", " + std::to_string(plan.cases.size()) + " cases of " + fixed(plan.seconds(), 0) +
                  " s, 2 peers of which one drives, netem \"" + plan.netem_text + "\"\n\n";
  s += "                                              combined inconsistency (m)  free ticks     peak of (m)    "
       "fidelity     "
       "updates   wire\n";
  s += "                                 input        mean  last third    peak  within  avatars  bodies  mean  peak    "
       "/min  kbit/s\n";
  const std::vector<std::string> kinds = kinds_of(plan);
  for (const Setting& setting : plan.settings) {
    std::string title = setting.title;
    for (const std::string& kind : kinds) {
      const auto mean = [&](double (*number_of)(const Measures&)) {
        return mean_of(over_cases(plan, r, setting.id, number_of, kind));
      };
      s += padded(title, 32) + " " + padded(kind, 10) +
           right(fixed(mean([](const Measures& m) { return m.combined.mean_m; }), 2), 7) +
           right(fixed(mean([](const Measures& m) { return m.thirds_m[2]; }), 2), 12) +
           right(fixed(mean([](const Measures& m) { return m.combined.peak_m; }), 2), 8) +
           right(percent(mean([](const Measures& m) { return m.free_within_share; })), 8) +
           right(fixed(mean([](const Measures& m) { return m.avatar_peak_m; }), 2), 9) +
           right(fixed(mean([](const Measures& m) { return m.body_peak_m; }), 2), 8) +
           right(fixed(mean([](const Measures& m) { return m.fidelity.mean_m; }), 2), 6) +
           right(fixed(mean([](const Measures& m) { return m.fidelity.peak_m; }), 2), 6) +
           right(fixed(mean([](const Measures& m) { return m.updates_per_min; }), 0), 8) +
           right(fixed(mean([](const Measures& m) { return m.kbps; }), 2), 8) + "\n";
      title.clear();
    }
  }
  s += "\nFree ticks within: of those at which the avatar touches nothing, those at which inconsistency is within the "
       "threshold.\nRuns, here of the first case:\n";
  for (const Setting& setting : plan.settings)
    s += "  " + run_command(plan.cases[0], setting, plan.scenario, plan.netem_text, plan.ticks) + "\n";
  s += "\npredictor      warnings right         contacts foreseen     of the time without contact\n";
  for (const char* predictor : kPredictors) {
    const PredictionScore p = score_of(plan, r, adaptive_id(predictor));
    s += padded(predictor, 15) + padded(percent(p.precision()) + " of " + std::to_string(p.right + p.wrong), 23) +
         padded(percent(p.recall()) + " of " + std::to_string(p.foreseen + p.unforeseen), 22) +
         percent(p.warned_share()) + " warned\n";
  }
  s += "\n";
  for (const Claim& c : claims)
    s += "Figure " + c.figure + ": " + padded(c.id, 24) + " holds for the means: " + (c.on_average ? "yes" : "NO ") +
         "; holds in single runs: " + share_text(c) + "\n";
  return s;
}

std::string json(const Plan& plan, const Results& r, const std::vector<Claim>& claims) {
  Json j;
  j.begin_object().field("program", "padr-lab").field("revision", shell::revision());
  j.field("command", plan.command).field("scenario", plan.scenario).field("netem", plan.netem_text);
  j.field("seconds", plan.seconds()).field("peers", 2);
  j.key("claims").begin_array();
  for (const Claim& c : claims) {
    j.begin_object().field("id", c.id).field("figure", c.figure).field("paper", c.says).field("test", c.test);
    j.field("measured", c.measured).field("holds_in", c.holds_in).field("of", c.of);
    j.field("holds_on_average", c.on_average).key("by_kind_of_input").begin_object();
    for (const auto& [kind, share] : c.by_kind)
      j.key(kind).begin_object().field("holds_in", share.holds_in).field("of", share.of).end_object();
    j.end_object().end_object();
  }
  j.end_array().key("predictors").begin_object();
  for (const char* predictor : kPredictors) {
    j.key(predictor).begin_object();
    put(j, score_of(plan, r, adaptive_id(predictor)));
    j.end_object();
  }
  j.end_object().key("means").begin_object();
  for (const Setting& s : plan.settings) {
    j.key(s.id).begin_object().field("technique", shell::describe(s.technique));
    for (const Column& c : kColumns) j.field(c.name, mean_of(over_cases(plan, r, s.id, c.value)));
    j.key("by_kind_of_input").begin_object();
    for (const std::string& kind : kinds_of(plan)) {
      j.key(kind).begin_object();
      for (const Column& c : kColumns) j.field(c.name, mean_of(over_cases(plan, r, s.id, c.value, kind)));
      j.end_object();
    }
    j.end_object().end_object();
  }
  j.end_object().key("cases").begin_array();
  for (std::size_t c = 0; c < plan.cases.size(); ++c) {
    j.begin_object()
        .field("case", plan.cases[c].id)
        .field("input", plan.cases[c].input)
        .field("kind", plan.cases[c].kind);
    j.field("seed", plan.cases[c].seed).key("runs").begin_object();
    for (std::size_t k = 0; k < plan.settings.size(); ++k) {
      j.key(plan.settings[k].id).begin_object();
      j.field("command", run_command(plan.cases[c], plan.settings[k], plan.scenario, plan.netem_text, plan.ticks));
      put_run(j, r.runs[c][k], r.measures[c][k]);
      j.end_object();
    }
    j.end_object().end_object();
  }
  return j.end_array().end_object().text();
}

std::vector<plot::NamedText> csv_files(const Plan& plan, const Results& r) {
  std::vector<plot::NamedText> files{{"runs.csv", runs_csv(plan, r)}, {"predictors.csv", predictors_csv(plan, r)}};
  for (std::size_t c = 0; c < plan.cases.size(); ++c)
    files.push_back({"series-" + plan.cases[c].id + ".csv", series_csv(plan, r.runs[c])});
  return files;
}

}  // namespace padr::lab::figures
