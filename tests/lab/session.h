#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/scenarios/scenarios.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "tools/lab/simulation.h"

namespace padr::test {

/// A simulation with wandering avatars, ready to run. With `one_plays` only the first does, as in the paper.
struct Session {
  Session(const std::string& scenario, int peers, const Technique& technique, const std::string& netem,
          std::uint64_t seed, int seconds, int settle_seconds = 0, bool one_plays = false) {
    lab::SimulationConfig c;
    c.scene = scenarios::load_embedded(scenario, seed);
    c.peers = peers;
    c.technique = technique;
    c.netem = shell::parse_netem(netem);
    c.netem_seed = seed;
    c.ticks = seconds * kTicksPerSecond;
    c.settle_ticks = settle_seconds * kTicksPerSecond;
    scene = c.scene;
    for (int p = 0; p < peers; ++p) {
      inputs.push_back(shell::make_input(one_plays && p > 0 ? "rest" : "wander", {scene, p, seed, {}}));
      c.inputs.push_back(inputs.back().get());
    }
    simulation = std::make_unique<lab::Simulation>(std::move(c));
  }

  Scene scene;
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::unique_ptr<lab::Simulation> simulation;
};

}  // namespace padr::test
