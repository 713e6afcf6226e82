#include "tools/lab/compare/trial.h"

#include <algorithm>
#include <memory>

#include "common/model/user_error.h"
#include "shell/scenario_flags.h"
#include "tools/lab/alternatives/alternative_run.h"
#include "tools/lab/measure/jumps.h"
#include "tools/lab/rates.h"
#include "tools/lab/simulation.h"

namespace padr::lab::compare {
namespace {

using Inputs = std::vector<std::unique_ptr<scenarios::InputSource>>;

Inputs load_inputs(const Setting& setting, const Scene& scene, std::uint64_t seed) {
  Inputs inputs;
  for (int p = 0; p < setting.peers; ++p)
    inputs.push_back(
        shell::load_input(setting.inputs[static_cast<std::size_t>(p) % setting.inputs.size()], scene, p, seed));
  return inputs;
}

shell::LoadedScenario load_with_room(const Setting& setting, std::uint64_t seed) {
  shell::LoadedScenario scenario = shell::load_scenario(setting.scenario, seed);
  const auto room = scenario.scene.avatar.spawns.size();
  if (static_cast<std::size_t>(setting.peers) > room)
    throw UserError("--peers: " + std::to_string(setting.peers) + " is too many for scenario " + setting.scenario +
                    ", which has room for " + std::to_string(room));
  return scenario;
}

void take_jumps(Score& score, const std::vector<const JumpMeter*>& meters, Tick ticks) {
  std::uint64_t jumps = 0;
  double metres = 0;
  for (const JumpMeter* m : meters) {
    jumps += m->jumps();
    metres += m->metres();
  }
  const double seconds = static_cast<double>(ticks) / kTicksPerSecond * static_cast<double>(meters.size());
  score.jumps = static_cast<double>(jumps) / seconds;
  score.jump_m = jumps == 0 ? 0 : metres / static_cast<double>(jumps);
}

/// Jumps of what the peers show.
class ShownJumps {
 public:
  explicit ShownJumps(const Simulation& s) : simulation_(s), meters_(static_cast<std::size_t>(s.peers())) {}
  void tick() {
    for (std::size_t p = 0; p < meters_.size(); ++p) {
      const node::Replica& replica = simulation_.replica(static_cast<PeerId>(p));
      velocity_.clear();
      for (const world::Kinematics& k : replica.live().world().kinematics()) velocity_.push_back(k.velocity);
      meters_[p].tick(replica.shown().positions(), velocity_);
    }
  }
  void take(Score& score) const {
    std::vector<const JumpMeter*> all;
    for (const JumpMeter& m : meters_) all.push_back(&m);
    take_jumps(score, all, simulation_.now());
  }

 private:
  const Simulation& simulation_;
  std::vector<JumpMeter> meters_;  ///< by peer
  std::vector<Vec2> velocity_;
};

Score run_technique(const Technique& technique, const Network& network, const Setting& setting, const Scene& scene,
                    std::uint64_t seed) {
  const Inputs inputs = load_inputs(setting, scene, seed);
  SimulationConfig config;
  config.scene = scene;
  config.peers = setting.peers;
  config.technique = technique;
  config.netem = network.spec;
  config.netem_seed = seed;
  config.ticks = setting.ticks;
  config.fidelity = true;
  for (const auto& i : inputs) config.inputs.push_back(i.get());
  config.processor_time = setting.processor_time;
  Simulation s(std::move(config));
  ShownJumps jumps(s);
  s.run([&jumps](Tick) { jumps.tick(); });
  Score score;
  score.off = s.meter().overall();
  score.fidelity = s.fidelity()->overall();
  score.delayed_mean_m = score.off.mean_m;
  score.hands_mean_m = score.off.mean_m;
  jumps.take(score);
  if (s.processor_time() != nullptr) score.processor_steps = s.processor_time()->steps();
  const Rates rates = rates_of(s, 0, setting.peers);
  score.kbps = rates.kbps;
  score.datagrams = rates.datagrams;
  score.updates = rates.updates;
  score.measured_share = s.measured_share();
  score.mismatches = s.confirmed_mismatches();
  return score;
}

Score run_alternative(const alternatives::Spec& spec, const Network& network, const Setting& setting,
                      const Scene& scene, std::uint64_t seed) {
  const Inputs inputs = load_inputs(setting, scene, seed);
  alternatives::SessionConfig config;
  config.scene = scene;
  config.peers = setting.peers;
  config.spec = spec;
  config.netem = network.spec;
  config.netem_seed = seed;
  for (const auto& i : inputs) config.inputs.push_back(i.get());
  config.processor_time = setting.processor_time;
  alternatives::AlternativeRun s(std::move(config));
  while (s.now() < setting.ticks) s.step();
  Score score;
  score.off = s.meter().overall();
  score.fidelity = s.fidelity().overall();
  score.delay_s = s.delay_s();
  score.delayed_mean_m = s.delayed_mean_m();
  score.hands_mean_m = s.hands_mean_m();
  const alternatives::Waiting waiting = s.waiting();
  score.hand_delay_s = waiting.hand_delay_s;
  score.hand_delay_peak_s = waiting.hand_delay_peak_s;
  score.frozen_share = waiting.frozen_share;
  score.freezes = waiting.freezes;
  score.mismatches = s.mismatches();
  if (s.processor_time() != nullptr) score.processor_steps = s.processor_time()->steps();
  std::vector<const JumpMeter*> meters;
  for (PeerId p = 0; p < setting.peers; ++p) meters.push_back(&s.jumps(p));
  take_jumps(score, meters, s.now());
  const double seconds = static_cast<double>(s.now()) / kTicksPerSecond * setting.peers;
  for (PeerId p = 0; p < setting.peers; ++p) {
    const alternatives::AlternativeStats& stats = s.peer(p).stats();
    score.kbps += static_cast<double>(stats.wire_bytes_sent) * 8 / 1000 / seconds;
    score.datagrams += static_cast<double>(stats.datagrams_sent) / seconds;
    const int receivers = std::max(1, setting.peers - 1);
    score.updates += static_cast<double>(stats.states_sent) / seconds / receivers;
    score.largest = std::max(score.largest, stats.largest);
  }
  return score;
}

}  // namespace

void check_setting(const Setting& setting, std::uint64_t seed) {
  load_inputs(setting, load_with_room(setting, seed).scene, seed);
}

Score run_trial(const Contestant& contestant, const Network& network, const Setting& setting, std::uint64_t seed) {
  const shell::LoadedScenario scenario = load_with_room(setting, seed);
  if (const auto* spec = std::get_if<alternatives::Spec>(&contestant.how))
    return run_alternative(*spec, network, setting, scenario.scene, seed);
  return run_technique(std::get<Technique>(contestant.how), network, setting, scenario.scene, seed);
}

}  // namespace padr::lab::compare
