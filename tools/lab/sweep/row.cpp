#include "tools/lab/sweep/row.h"

#include <cmath>

#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "shell/scenario_flags.h"
#include "shell/technique_text.h"
#include "shell/text.h"
#include "tools/lab/rates.h"
#include "tools/lab/sweep/rows_file.h"
#include "tools/lab/sweep/values.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab::sweep {
namespace {

constexpr const char* kOutcome =
    "mean_m,avatar_mean_m,body_mean_m,p95_m,p99_m,peak_m,final_m,area_ms,shown_mean_m,shown_peak_m,updates_per_s,"
    "datagrams_per_s,wire_kbps,repeats_per_s,replay_steps_per_tick,lookahead_steps_per_tick,"
    "fidelity_mean_m,fidelity_own_mean_m,fidelity_others_mean_m,fidelity_nobody_mean_m,fidelity_p95_m,fidelity_peak_m,"
    "fidelity_left_out,confirmed_ticks,"
    "confirmed_mismatches,confirmed_hash,setting";

Scene scene_of(const Point& p) {
  shell::LoadedScenario s = shell::load_scenario(p.scenario, p.seed);
  if (!p.bodies) return s.scene;
  const std::string label = "--bodies " + std::to_string(*p.bodies) + ": " + p.scenario;
  return scenarios::load(scenarios::with_bodies(s.text, label, *p.bodies), label, p.seed);
}

std::string outcome(const Simulation& s, const Technique& technique, std::optional<PeerId> watched) {
  const trace::Inconsistency i = watched ? trace::summarize(s.seen_with_input(*watched)) : s.meter().overall();
  const Rates r = rates_of(s, 0, s.peers());
  const trace::Fidelity f = watched ? s.fidelity()->result(*watched) : s.fidelity()->overall();
  std::string text;
  for (const double v : {i.mean_m,
                         i.avatar_mean_m,
                         i.body_mean_m,
                         i.p95_m,
                         i.p99_m,
                         i.peak_m,
                         i.final_m,
                         i.area_ms,
                         i.shown_mean_m,
                         i.shown_peak_m,
                         r.updates,
                         r.datagrams,
                         r.kbps,
                         r.repeats,
                         r.replay_steps_per_tick,
                         r.lookahead_steps_per_tick,
                         f.mean_m,
                         f.own_mean_m,
                         f.others_mean_m,
                         f.nobody_mean_m,
                         f.p95_m,
                         f.peak_m,
                         s.fidelity()->left_out()})
    text += plot::number(v) + ",";
  return text + std::to_string(s.confirmed_ticks()) + "," + std::to_string(s.confirmed_mismatches()) + "," +
         shell::hex(s.last_confirmed_hash()) + "," + shell::csv_field(shell::describe(technique));
}

}  // namespace

std::string heading_of(const Grid& grid) {
  std::string knobs;
  for (const std::string& k : grid.knob_columns()) knobs += k + ",";
  for (const auto& [name, value] : grid.given()) knobs += name + ",";
  return "grid,run,of,scenario,bodies,peers,delay_ms,jitter_ms,loss_percent,technique," + knobs + "seed,seconds," +
         kOutcome;
}

std::string run_point(const Grid& grid, std::size_t index) {
  const Point p = grid.point(index);
  SimulationConfig config;
  config.scene = scene_of(p);
  const std::size_t bodies = config.scene.bodies.size();
  config.peers = p.peers;
  config.technique = p.technique;
  config.netem = p.netem;
  config.netem_seed = p.seed;
  config.ticks = static_cast<Tick>(std::lround(grid.seconds() * kTicksPerSecond));
  config.settle_ticks = static_cast<Tick>(std::lround(grid.settle_seconds() * kTicksPerSecond));
  config.fidelity = true;
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  for (int peer = 0; peer < p.peers; ++peer) {
    const std::string& spec = grid.inputs()[static_cast<std::size_t>(peer) % grid.inputs().size()];
    inputs.push_back(shell::load_input(spec, config.scene, peer, p.seed));
    config.inputs.push_back(inputs.back().get());
  }
  Simulation simulation(std::move(config));
  simulation.run();

  std::string text = grid.id() + "," + std::to_string(index) + "," + std::to_string(grid.size()) + "," +
                     shell::csv_field(p.scenario) + "," + std::to_string(bodies) + "," + std::to_string(p.peers) + "," +
                     plain(p.delay_ms) + "," + plain(p.jitter_ms) + "," +
                     (p.loss_percent ? plain(*p.loss_percent) : "") + "," + shell::csv_field(p.technique_name) + ",";
  for (const std::string& k : p.knobs) text += shell::csv_field(k) + ",";
  for (const auto& [name, value] : grid.given()) text += shell::csv_field(value) + ",";
  text += std::to_string(p.seed) + "," + plain(grid.seconds()) + "," + outcome(simulation, p.technique, grid.watched());
  return text;
}

}  // namespace padr::lab::sweep
