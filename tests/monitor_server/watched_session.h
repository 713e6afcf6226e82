#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "common/monitor/codec.h"
#include "common/monitor/sampler.h"
#include "common/scenarios/scenarios.h"
#include "common/sync/state_hash.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "shell/technique_text.h"
#include "tools/lab/simulation.h"

namespace padr::test {

/// Peers on virtual time over a bad network, all of whom tell a monitor at every third tick.
class WatchedSession {
 public:
  using Listener = std::function<void(const monitor::Origin&, const monitor::Message&)>;

  WatchedSession(int peers, Tick ticks, std::uint64_t seed) : scene(scenarios::load_embedded("arena", seed)) {
    lab::SimulationConfig c;
    c.scene = scene;
    c.peers = peers;
    c.netem = shell::parse_netem("delay 80ms 30ms loss 5%");
    c.netem_seed = seed;
    c.ticks = ticks;
    c.on_confirmed = [this](PeerId p, const sync::FoldState& s) {
      if (!samplers_.empty() && samplers_[p].due(s.tick)) {
        monitor::Agreed a;
        monitor::Sampler::agreed(s, sync::hash_of(s), true, a);
        agreed_.emplace_back(p, std::move(a));
      }
    };
    for (int p = 0; p < peers; ++p) {
      inputs_.push_back(shell::make_input("wander", {scene, p, seed, {}}));
      c.inputs.push_back(inputs_.back().get());
      samplers_.emplace_back(20, monitor::Detail::kAll);
    }
    simulation = std::make_unique<lab::Simulation>(c);
  }

  static monitor::Origin origin(PeerId p) { return {100 + std::uint64_t{p}, 7, p, 0}; }

  monitor::Hello hello() const {
    monitor::Hello h;
    h.version = "test";
    h.slots = simulation->peers();
    h.scenario = "arena";
    h.technique = shell::describe(Technique{});
    h.rate = 20;
    return h;
  }

  /// Plays all ticks; `after` sees each.
  void run(const Listener& listener, const std::function<void(Tick)>& after = {}) {
    for (PeerId p = 0; p < simulation->peers(); ++p) {
      listener(origin(p), hello());
      samplers_[p].begin(simulation->replica(p), "");
    }
    simulation->run([&](Tick t) {
      for (auto& [p, a] : agreed_) listener(origin(p), a);
      agreed_.clear();
      for (PeerId p = 0; p < simulation->peers(); ++p) tell(p, listener);
      if (after) after(t);
    });
  }

  Scene scene;
  std::unique_ptr<lab::Simulation> simulation;

 private:
  void tell(PeerId p, const Listener& listener) {
    const node::Replica& replica = simulation->replica(p);
    samplers_[p].observe(replica);
    auto events = samplers_[p].take_events();
    if (!events.empty()) listener(origin(p), monitor::Events{std::move(events)});
    if (!samplers_[p].due(replica.now())) return;
    monitor::Frame f;
    samplers_[p].frame(replica, {1, 2}, f);
    listener(origin(p), f);
    listener(origin(p), monitor::Sampler::status(replica));
  }

  std::vector<std::unique_ptr<scenarios::InputSource>> inputs_;
  std::vector<monitor::Sampler> samplers_;
  std::vector<std::pair<PeerId, monitor::Agreed>> agreed_;
};

}  // namespace padr::test
