#include "tools/lab/benchmark/benchmark.h"

#include <fmt/printf.h>

#include <charconv>

#include "common/model/hash.h"
#include "common/model/user_error.h"
#include "common/world/fingerprint.h"
#include "shell/files.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "shell/revision.h"
#include "shell/scenario_flags.h"
#include "shell/text.h"
#include "tools/lab/compare/fields.h"
#include "tools/lab/sweep/rows_file.h"

namespace padr::lab::benchmark {
namespace {

constexpr std::size_t kLeading = 7;  // columns before the figures

void add_input(Hasher& h, const std::string& input) {
  h.add(std::string_view(input));
  if (const auto path = shell::path_text(input)) h.add(std::string_view(shell::read_file("--input", path->file)));
}

void add_alternative(Hasher& h, const alternatives::Spec& s) {
  for (const int v : {static_cast<int>(s.kind), s.hz, s.input_delay, s.prediction, s.steps_per_m})
    h.add(static_cast<std::uint64_t>(v));
  h.add(s.position_threshold, s.angle_threshold);
}

std::string number(double v) {
  return fmt::sprintf("%.6g", v);
}

/// What its code does, which nothing but a run can tell: a file in entrants/ may have changed since the revision.
void add_entrant(Hasher& h, const compare::Contestant& c) {
  compare::Setting setting;
  setting.peers = 3;
  setting.ticks = 4 * kTicksPerSecond;
  constexpr const char* kLink = "delay 50ms 20ms loss 10%";
  const compare::Score score = compare::run_trial(c, {kLink, shell::parse_netem(kLink, nullptr)}, setting, 1);
  for (const compare::Field& f : compare::fields()) h.add(std::string_view(number(f.of(score))));
}

double number_of(const std::string& text, const std::string& where) {
  double v{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc{} || end != text.data() + text.size())
    throw UserError(where + ": '" + text + "' is no number; remove the file to begin again");
  return v;
}

}  // namespace

Benchmark::Benchmark(compare::Plan plan) : plan_(std::move(plan)) {
  plan_.setting.processor_time = true;
  id_ = identify();
}

std::string Benchmark::identify() const {
  Hasher h;
  h.add(shell::revision());
  h.add(world::physics_fingerprint());
  const compare::Setting& s = plan_.setting;
  h.add(std::string_view(s.scenario));
  h.add(std::string_view(shell::load_scenario(s.scenario, plan_.seeds.front()).text));
  h.add(static_cast<std::uint64_t>(s.peers));
  h.add(static_cast<std::uint64_t>(s.ticks));
  for (const std::string& input : s.inputs) add_input(h, input);
  for (const compare::Network& n : plan_.networks) {
    h.add(std::string_view(n.text));
    if (n.spec.trace.opportunities)
      for (const std::uint32_t ms : *n.spec.trace.opportunities) h.add(std::uint64_t{ms});
  }
  for (const compare::Contestant& c : plan_.contestants) {
    h.add(std::string_view(c.id));
    h.add(std::string_view(c.setting()));
    const auto* spec = std::get_if<alternatives::Spec>(&c.how);
    if (spec == nullptr) continue;
    add_alternative(h, *spec);
    if (spec->kind == alternatives::Kind::kEntrant) add_entrant(h, c);
  }
  for (const std::uint64_t seed : plan_.seeds) h.add(seed);
  return fmt::sprintf("%08x", static_cast<unsigned>(h.value() >> 32U));
}

Benchmark::Place Benchmark::place(std::size_t run) const {
  const std::size_t seeds = plan_.seeds.size();
  const std::size_t of_network = plan_.contestants.size() * seeds;
  return {&plan_.networks[run / of_network], &plan_.contestants[run % of_network / seeds], plan_.seeds[run % seeds]};
}

std::string Benchmark::heading() const {
  std::string text = "grid,run,of,revision,technique,netem,seed";
  for (const compare::Field& f : compare::fields()) text += std::string(",") + f.name;
  return text + "," + compare::kProcessorColumn;
}

std::string Benchmark::play(std::size_t run) const {
  const Place at = place(run);
  const compare::Score score = compare::run_trial(*at.who, *at.network, plan_.setting, at.seed);
  std::string text = id_ + "," + std::to_string(run) + "," + std::to_string(size()) + "," +
                     shell::csv_field(shell::revision()) + "," + shell::csv_field(at.who->id) + "," +
                     shell::csv_field(at.network->text) + "," + std::to_string(at.seed);
  for (const compare::Field& f : compare::fields()) text += "," + number(f.of(score));
  return text + "," + number(score.processor_steps.value_or(0));
}

sweep::SweepResult Benchmark::run(const std::string& file) const {
  return sweep::run_missing({id_, size(), heading(), [this](std::size_t run) { return play(run); }, "--out"}, {}, file,
                            plan_.parallel);
}

std::vector<compare::Row> Benchmark::rows(const std::string& file) const {
  const sweep::StoredRows stored = sweep::read_rows("--out", file);
  std::vector<compare::Row> rows;
  std::size_t run = 0;
  for (const sweep::StoredRow& row : stored.rows) {
    const std::string where = "--out: " + file + ":" + std::to_string(row.line);
    if (row.grid != id_ || row.run != run)
      throw UserError(where + ": is not run " + std::to_string(run) + " of " + id_);
    const Place at = place(run++);
    const std::vector<std::string> columns = sweep::fields_of(row.text);
    compare::Score score;
    std::size_t column = kLeading;
    for (const compare::Field& f : compare::fields()) f.put(score, number_of(columns[column++], where));
    score.processor_steps = number_of(columns[column], where);
    if (at.seed == plan_.seeds.front()) rows.push_back({*at.who, at.network->text, {}});
    rows.back().scores.push_back(score);
  }
  if (run != size())
    throw UserError("--out: " + file + ": has " + std::to_string(run) + " of " + std::to_string(size()) + " runs");
  return rows;
}

}  // namespace padr::lab::benchmark
