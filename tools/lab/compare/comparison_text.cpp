#include <fmt/printf.h>

#include <algorithm>
#include <cmath>

#include "shell/json.h"
#include "shell/revision.h"
#include "tools/lab/compare/comparison.h"
#include "tools/lab/compare/fields.h"

namespace padr::lab::compare {
namespace {

std::string network_name(const std::string& text) {
  return text.empty() ? "unimpaired" : "netem \"" + text + "\"";
}

const Row* full_of(const std::vector<Row>& rows, const std::string& network) {
  const auto full =
      std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.who.id == "full" && r.network == network; });
  return full == rows.end() ? nullptr : &*full;
}

/// Whether a difference in the mean is more than chance: the same seeds, run by run, more than two standard errors.
bool is_told_apart(const Row& row, const Row& full) {
  const std::size_t n = std::min(row.scores.size(), full.scores.size());
  if (n < 2) return false;
  double mean = 0;
  for (std::size_t i = 0; i < n; ++i)
    mean += (row.scores[i].off.mean_m - full.scores[i].off.mean_m) / static_cast<double>(n);
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double off = row.scores[i].off.mean_m - full.scores[i].off.mean_m - mean;
    squares += off * off;
  }
  return std::abs(mean) > 2 * std::sqrt(squares / static_cast<double>(n - 1) / static_cast<double>(n));
}

std::string line_of(const Row& row, const std::vector<Row>& rows, int width) {
  const auto mean = [&row](double (*of)(const Score&)) { return row.over(of).mean; };
  const Figure off = row.over([](const Score& s) { return s.off.mean_m; });
  const Figure peak = row.over([](const Score& s) { return s.off.peak_m; });
  const double delay = mean([](const Score& s) { return s.delay_s; });
  std::string then = "      -      -";
  if (delay > 0)
    then = fmt::sprintf("%7.3f %6.0f", mean([](const Score& s) { return s.delayed_mean_m; }), delay * 1000);
  std::string against = "      -     -";
  if (const Row* full = full_of(rows, row.network);
      full != nullptr && full != &row && full->mean_m() > 0 && full->kbps() > 0)
    against = fmt::sprintf("%6.2f%s %5.2f", row.mean_m() / full->mean_m(), is_told_apart(row, *full) ? " " : "~",
                           row.kbps() / full->kbps());
  return fmt::sprintf("  %-*s %7.3f %6.3f %8.3f %7.3f %6.2f %6.2f %7.2f %8.3f %s %7.1f %6.1f  %s\n", width,
                      row.who.id.c_str(), off.mean, off.error, mean([](const Score& s) { return s.off.avatar_mean_m; }),
                      mean([](const Score& s) { return s.off.body_mean_m; }),
                      mean([](const Score& s) { return s.off.p95_m; }), peak.mean, peak.high,
                      mean([](const Score& s) { return s.fidelity.mean_m; }), then.c_str(), row.kbps(),
                      mean([](const Score& s) { return s.datagrams; }), against.c_str());
}

/// The second table: what hands and eyes meet.
std::string meeting_of(const Row& row, const std::vector<Row>& rows, int width) {
  const auto mean = [&row](double (*of)(const Score&)) { return row.over(of).mean; };
  const auto steps = row.processor_steps();
  const auto full = full_for_no_more(row, rows);
  return fmt::sprintf(
      "  %-*s %8.0f %6.0f %8.3f %7.1f %6.2f %7.2f %6.3f %9s %11s\n", width, row.who.id.c_str(),
      mean([](const Score& s) { return s.hand_delay_s * 1000; }),
      row.over([](const Score& s) { return s.hand_delay_peak_s * 1000; }).high,
      mean([](const Score& s) { return s.hands_mean_m; }), mean([](const Score& s) { return s.frozen_share * 100; }),
      mean([](const Score& s) { return s.freezes; }), mean([](const Score& s) { return s.jumps; }),
      row.over([](const Score& s) { return s.jump_m; }, has_jumps).mean,
      steps ? fmt::sprintf("%.1f", *steps).c_str() : "-", full ? fmt::sprintf("%.3f", *full).c_str() : "-");
}

std::string better_than_full(const std::vector<Row>& rows, const std::string& network) {
  std::string list;
  for (const Row& r : rows)
    if (r.network == network && standing(r, rows) == Standing::kDominates)
      list += (list.empty() ? "" : ", ") + r.who.id;
  return "  less of both than full: " + (list.empty() ? "none" : list) + "\n";
}

}  // namespace

std::string table(const std::vector<Row>& rows, const Plan& plan) {
  const Setting& s = plan.setting;
  std::string inputs;
  for (const std::string& i : s.inputs) inputs += (inputs.empty() ? "" : ", ") + i;
  std::string t = fmt::sprintf("%s, %d peers, %g s, %zu seeds, input %s\n", s.scenario.c_str(), s.peers,
                               static_cast<double>(s.ticks) / kTicksPerSecond, plan.seeds.size(), inputs.c_str());
  std::size_t longest = 9;
  for (const Contestant& c : plan.contestants) longest = std::max(longest, c.id.size());
  const auto width = static_cast<int>(longest);
  for (const Network& n : plan.networks) {
    t += "\n" + network_name(n.text) + "\n";
    t += fmt::sprintf(
        "  %-*s combined inconsistency against now (m), all entities          fidelity   of the past    by a peer     "
        "times full\n",
        width, "");
    t += fmt::sprintf(
        "  %-*s    mean     +-  avatars  bodies    p95   peak highest  error m  mean m     ms  kbit/s  dgr/s       m  "
        "kbit\n",
        width, "technique");
    for (const Row& r : rows)
      if (r.network == n.text) t += line_of(r, rows, width);
    t += fmt::sprintf("\n  %-*s hand-to-avatar  against    frozen          jumps            processor  full for no\n",
                      width, "");
    t += fmt::sprintf("  %-*s mean ms   peak  hands m       %%      /s      /s mean m      steps  more kbit m\n", width,
                      "technique");
    for (const Row& r : rows)
      if (r.network == n.text) t += meeting_of(r, rows, width);
    if (full_of(rows, n.text) != nullptr) t += better_than_full(rows, n.text);
    if (const std::string note = little_measured(rows, n.text, s.ticks); !note.empty()) t += "  " + note + "\n";
  }
  t += "\n+-: standard error of the mean over the seeds. ~: the difference from full, run by run with the same seeds, "
       "is below\ntwo standard errors. Peak: mean of the seeds' peaks; highest: the highest of all seeds. kbit/s: sent "
       "to all others\ntogether, with 28 bytes of IP and UDP headers in each datagram. Of the past: error against the "
       "past that the\ntechnique shows. Below 5 mm it is noise.\n"
       "Hand-to-avatar: from an input at the hand to the own avatar that follows it; peak: the longest of all. Against "
       "hands: the\nmean against where the hands of now put things, input delay or not. Frozen: ticks at which a view "
       "stood still, and how\noften a second. Jumps: of shown positions by over 3 cm, per second a peer. Processor: of "
       "a "
       "peer in a tick, in steps of a\nbare Box2D world in the same run (--processor-time). Full for no more kbit: the "
       "least mean of full at a budget with which\nit sends no more; with --techniques frontier.\n"
       "Fidelity error: distance between bodies and the result of the players' deeds alone (docs/metrics.md).\n\n";
  for (const Contestant& c : plan.contestants) t += fmt::sprintf("  %-*s ", width, c.id.c_str()) + c.setting() + "\n";
  return t;
}

std::string json(const std::vector<Row>& rows, const Plan& plan, const std::string& command) {
  shell::Json j;
  j.begin_object().field("command", command).field("revision", shell::revision());
  j.field("scenario", plan.setting.scenario);
  j.field("peers", plan.setting.peers);
  j.field("seconds", static_cast<double>(plan.setting.ticks) / kTicksPerSecond);
  j.key("inputs").begin_array();
  for (const std::string& i : plan.setting.inputs) j.value(i);
  j.end_array().key("seeds").begin_array();
  for (const std::uint64_t s : plan.seeds) j.value(s);
  j.end_array().key("rows").begin_array();
  for (const Row& r : rows) {
    j.begin_object().field("technique", r.who.id).field("netem", r.network).field("what", r.who.what);
    j.field("setting", r.who.setting());
    for (const Field& f : fields()) {
      const Figure v = r.over(f.of, f.has);
      j.key(f.name).begin_object().field("mean", v.mean).field("low", v.low).field("high", v.high);
      j.field("error", v.error).end_object();
    }
    if (const auto steps = r.processor_steps()) j.field("processor_steps", *steps);
    j.end_object();
  }
  j.end_array().end_object();
  return j.text();
}

std::string csv(const std::vector<Row>& rows, const Plan& plan) {
  std::string c = "technique,netem,seed";
  for (const Field& f : fields()) c += std::string(",") + f.name;
  c += "\n";
  for (const Row& r : rows) {
    for (std::size_t i = 0; i < r.scores.size(); ++i) {
      c += r.who.id + ",\"" + r.network + "\"," + std::to_string(plan.seeds[i]);
      for (const Field& f : fields()) c += fmt::sprintf(",%.6g", f.of(r.scores[i]));
      c += "\n";
    }
  }
  return c;
}

}  // namespace padr::lab::compare
