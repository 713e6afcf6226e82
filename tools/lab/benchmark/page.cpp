#include "tools/lab/benchmark/page.h"

#include <fmt/printf.h>

#include "shell/revision.h"
#include "shell/text.h"

namespace padr::lab::benchmark {
namespace {

using compare::Row;
using compare::Score;

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>padr-lab benchmark</title><style>
  body { font: 16px/1.5 sans-serif; color: #222; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; }
  h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.5rem; border-top: 1px solid #ccc; padding-top: 1rem; }
  img { max-width: 100%; height: auto; }
  .wide { overflow-x: auto; }
  table { border-collapse: collapse; font-size: 0.85rem; margin: 1rem 0; }
  th, td { padding: 0.15rem 0.6rem; text-align: right; border-bottom: 1px solid #ddd; }
  th:first-child, td:first-child { text-align: left; }
  tr.full { background: #e6f3ee; } td.wins { font-weight: bold; }
  code { background: #f2f2f2; }
</style></head><body><main>
)";

std::string cell(double v, int digits, const char* look = "") {
  return fmt::sprintf("<td%s>%.*f</td>", look, digits, v);
}

std::string line_of(const Row& r, const std::vector<Row>& rows) {
  const auto mean = [&r](double (*of)(const Score&)) { return r.over(of).mean; };
  const auto full = compare::full_for_no_more(r, rows);
  const bool ours = compare::is_budget_of_full(r.who);
  const bool wins = !ours && full && r.mean_m() < *full;
  std::string t = std::string("<tr") + (ours ? " class=\"full\"" : "") + "><td title=\"" +
                  shell::html_escaped(r.who.setting()) + "\">" + shell::html_escaped(r.who.id) + "</td>";
  t += cell(r.kbps(), 1) + cell(r.mean_m(), 3, wins ? " class=\"wins\"" : "");
  t += full ? cell(*full, 3) : "<td>-</td>";
  t += cell(mean([](const Score& s) { return s.hands_mean_m; }), 3);
  t += cell(mean([](const Score& s) { return s.hand_delay_s * 1000; }), 0);
  t += cell(mean([](const Score& s) { return s.fidelity.mean_m; }), 3);
  t += cell(mean([](const Score& s) { return s.off.shown_mean_m; }), 3);
  t += cell(mean([](const Score& s) { return s.off.peak_m; }), 2);
  t += cell(mean([](const Score& s) { return s.frozen_share * 100; }), 1);
  t += cell(mean([](const Score& s) { return s.freezes; }), 2);
  t += cell(mean([](const Score& s) { return s.jumps; }), 2);
  t += cell(r.processor_steps().value_or(0), 1);
  return t + "</tr>\n";
}

constexpr const char* kColumns =
    "<tr><th>technique</th><th>kbit/s a peer</th><th>mean (m)</th><th>full for no more</th><th>against hands (m)</th>"
    "<th>hand to avatar (ms)</th><th>fidelity error (m)</th><th>shown (m)</th><th>peak (m)</th><th>frozen (%)</th>"
    "<th>freezes/s</th><th>jumps/s</th><th>processor (steps)</th></tr>\n";

std::string beginning(const compare::Plan& plan, const std::string& command, const std::string& id) {
  const compare::Setting& s = plan.setting;
  std::string inputs;
  for (const std::string& i : s.inputs) inputs += (inputs.empty() ? "" : ", ") + i;
  std::string t = kHead;
  t += "<h1>padr-lab benchmark " + id + "</h1>\n<p>" +
       fmt::sprintf("Scenario %s, %d peers, %g s, seeds %u to %u, input %s. ", shell::html_escaped(s.scenario).c_str(),
                    s.peers, static_cast<double>(s.ticks) / kTicksPerSecond, static_cast<unsigned>(plan.seeds.front()),
                    static_cast<unsigned>(plan.seeds.back()), shell::html_escaped(inputs).c_str());
  t += "Measured at revision " + shell::html_escaped(std::string(shell::revision())) + " by <code>" +
       shell::html_escaped(command) +
       "</code>. All figures: <a href=\"results.csv\">results.csv</a> (each run), "
       "<a href=\"results.json\">results.json</a> (means); <a href=\"inputs\">inputs</a>.</p>\n";
  t +=
      "<p>Mean: combined inconsistency, all entities. Full for no more: the least that full has at a budget with which "
      "it sends no more than the row; bold: the row has less. Against hands: against where the hands of now put "
      "things, input delay or not. Hand to avatar: from an input until the own avatar follows. Frozen: ticks at which "
      "a view stood still. Jumps: of shown positions by over 3 cm. Processor: a peer's tick, in steps of a bare Box2D "
      "world in the same run.</p>\n";
  return t;
}

}  // namespace

std::string page(const std::vector<Row>& rows, const compare::Plan& plan, const std::string& command,
                 const std::string& id) {
  std::string t = beginning(plan, command, id);
  for (const compare::Network& n : plan.networks) {
    const std::string name = n.text.empty() ? "unimpaired" : shell::html_escaped(n.text);
    t += "<h2>" + name + "</h2>\n<img src=\"" + compare::frontier_name(n.text) +
         ".svg\" alt=\"mean inconsistency against traffic: " + name +
         "\">\n<div class=\"wide\" tabindex=\"0\"><table>\n" + kColumns;
    for (const Row& r : rows)
      if (r.network == n.text) t += line_of(r, rows);
    t += "</table></div>\n";
    if (const std::string note = compare::little_measured(rows, n.text, plan.setting.ticks); !note.empty())
      t += "<p>" + shell::html_escaped(note) + "</p>\n";
  }
  return t + "</main></body></html>\n";
}

}  // namespace padr::lab::benchmark
