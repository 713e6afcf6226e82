#include "tools/lab/figures/run.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <memory>

#include "shell/command_line.h"
#include "shell/scenario_flags.h"
#include "shell/technique_text.h"
#include "tools/lab/simulation.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab::figures {
namespace {

constexpr PeerId kDriver = 0;
constexpr PeerId kWatcher = 1;

// What happens in the last moments is confirmed, and so measured, a little later.
constexpr Tick kConfirmTicks = 5 * kTicksPerSecond;

bool touches_body(const sync::LiveWorld& live) {
  const EntityId avatar = live.avatar();
  const world::View& w = live.world();
  return std::any_of(live.touching().begin(), live.touching().end(), [&](const Contact& c) {
    return (c.first == avatar && !w.is_avatar(c.second)) || (c.second == avatar && !w.is_avatar(c.first));
  });
}

void note_traffic(const node::ReplicaStats& stats, FigureRun& r) {
  r.updates_by_cause = stats.updates_by_cause;
  for (const std::uint64_t n : r.updates_by_cause) r.updates += n;
  r.datagrams = stats.datagrams_sent;
  r.wire_bytes = stats.wire_bytes_sent;
}

Setting setting(const std::string& name, const std::string& threshold, const std::string& predictor) {
  const Technique t =
      shell::technique_of(name + " --threshold " + threshold + (predictor.empty() ? "" : " --predictor " + predictor));
  std::string id = name + "-" + threshold;
  std::replace(id.begin(), id.end(), ':', '-');
  std::string title = name + " " + threshold + " m";
  if (!predictor.empty()) {
    id += "-" + predictor;
    title += ", " + predictor;
  }
  return {id, title, t};
}

}  // namespace

FigureRun run_figure(const Case& c, const Setting& s, const link::NetemSpec& netem, Tick ticks) {
  const auto driver = shell::load_input(c.input, c.scene, kDriver, c.seed);
  const auto watcher = shell::load_input("rest", c.scene, kWatcher, c.seed);
  SimulationConfig config;
  config.scene = c.scene;
  config.technique = s.technique;
  config.netem = netem;
  config.netem_seed = c.seed;
  config.inputs = {driver.get(), watcher.get()};
  config.ticks = ticks;
  config.settle_ticks = kConfirmTicks;
  config.fidelity = true;
  Simulation simulation(std::move(config));

  FigureRun r;
  std::vector<bool> predicted;
  simulation.run([&](Tick now) {
    if (now > ticks) return;
    const node::Replica& replica = simulation.replica(kDriver);
    const world::View& live = replica.live().world();
    r.threshold_m.push_back(replica.threshold());
    r.touching.push_back(touches_body(replica.live()));
    r.path.push_back(live.position(replica.live().avatar()));
    predicted.push_back(replica.prediction().interaction);
    if (now < ticks) return;
    note_traffic(replica.stats(), r);
    for (EntityId b = 0; b < live.bodies(); ++b) r.bodies_end.push_back(live.state(b));
  });
  r.watched = simulation.seen_with_input(kWatcher);
  const auto counts = [ticks](const auto& p) { return p.tick >= 1 && p.tick <= ticks; };
  const auto& deeds = simulation.fidelity()->series(kWatcher);
  std::copy_if(deeds.begin(), deeds.end(), std::back_inserter(r.fidelity), counts);
  const auto& cost = simulation.fidelity()->pcc().series(kDriver);
  std::copy_if(cost.begin(), cost.end(), std::back_inserter(r.pcc), counts);
  r.score = score_predictions(predicted, r.touching, s.technique.steps);
  r.confirmed_mismatches = simulation.confirmed_mismatches();
  return r;
}

std::string run_command(const Case& c, const Setting& s, const std::string& scenario, const std::string& netem,
                        Tick ticks) {
  const auto seconds = [](Tick t) { return plot::number(static_cast<double>(t) / kTicksPerSecond); };
  std::vector<std::string> words{"padr-lab",   "run",
                                 "--scenario", scenario,
                                 "--seed",     std::to_string(c.seed),
                                 "--input",    c.input,
                                 "--input",    "rest",
                                 "--seconds",  seconds(ticks),
                                 "--settle",   seconds(kConfirmTicks),
                                 "--watch",    std::to_string(kWatcher)};
  if (!netem.empty()) words.insert(words.end(), {"--netem", netem});
  return shell::shell_line(words) + " --technique " + shell::describe(s.technique);
}

std::vector<Setting> figure_settings() {
  std::vector<Setting> all;
  for (const char* name : {"avatar-only", "fixed"})
    for (const char* threshold : kThresholds) all.push_back(setting(name, threshold, ""));
  for (const char* predictor : kPredictors) all.push_back(setting("adaptive", "0.8:0.3", predictor));
  Setting full = setting("full", "0.8:0.3", "");
  full.technique.body_threshold = 0.1F;
  all.push_back(std::move(full));
  return all;
}

std::string adaptive_id(const std::string& predictor) {
  return "adaptive-0.8-0.3-" + predictor;
}

std::size_t setting_index(const std::vector<Setting>& settings, const std::string& id) {
  const auto at = std::find_if(settings.begin(), settings.end(), [&id](const Setting& s) { return s.id == id; });
  assert(at != settings.end());
  return static_cast<std::size_t>(at - settings.begin());
}

}  // namespace padr::lab::figures
