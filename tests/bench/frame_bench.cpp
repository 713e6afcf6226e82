// What a frame costs, as a multiple of one bare step of the same scene in the same run (counter `steps`).
#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>

#include "common/link/netem_spec.h"
#include "common/scenarios/scenarios.h"
#include "tools/lab/simulation.h"

namespace padr {
namespace {

constexpr int kPeers = 4;
constexpr Tick kTicks = 20 * kTicksPerSecond;

struct Play {
  explicit Play(const char* scenario) {
    lab::SimulationConfig c;
    c.scene = scenarios::load_embedded(scenario, 1);
    c.peers = kPeers;
    c.netem = link::parse_netem("delay 100ms loss 2%");
    c.ticks = kTicks;
    for (int p = 0; p < kPeers; ++p) {
      inputs.push_back(scenarios::make_input("wander", {c.scene, p, 1, {}}));
      c.inputs.push_back(inputs.back().get());
    }
    simulation = std::make_unique<lab::Simulation>(std::move(c));
  }
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::unique_ptr<lab::Simulation> simulation;
};

/// Seconds that the bare steps of one peer's live world take: the same positions at every tick, nothing else done.
double bare_seconds(const char* scenario) {
  Play play(scenario);
  world::World bare(play.simulation->node(0).live().world().scene(), kPeers);
  world::Snapshot s;
  double seconds = 0;
  for (Tick t = 0; t < kTicks; ++t) {
    play.simulation->step();
    play.simulation->node(0).live().world().save(s);
    bare.restore(s);
    const auto start = std::chrono::steady_clock::now();
    bare.step();
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  return seconds;
}

void frame(benchmark::State& state, const char* scenario) {
  const double bare = bare_seconds(scenario);
  double spent = 0;
  for (auto unused : state) {
    (void)unused;
    state.PauseTiming();
    Play play(scenario);
    state.ResumeTiming();
    const auto start = std::chrono::steady_clock::now();
    play.simulation->run();
    spent += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  const auto frames = static_cast<double>(state.iterations()) * kTicks * kPeers;
  state.counters["frame_us"] = spent * 1e6 / frames;
  state.counters["bare_step_us"] = bare * 1e6 / kTicks;
  state.counters["steps"] = spent / frames / (bare / kTicks);
}

BENCHMARK_CAPTURE(frame, arena, "arena")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, clutter, "clutter")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace padr
