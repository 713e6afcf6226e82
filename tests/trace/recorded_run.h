#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/link/link_mesh.h"
#include "common/replica/recorded_replica.h"
#include "common/scenarios/input.h"
#include "common/scenarios/scenarios.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "tools/lab/simulation.h"

namespace padr::test {

struct RunConfig {
  std::string scenario = "arena";
  std::uint64_t seed = 1;
  int peers = 2;
  std::string netem = "delay 100ms 50ms loss 10%";
  Tick ticks = 300;
  Technique technique;
  std::optional<Technique> second_technique;  ///< of peer 1
  Tick leave_at = 0;                          ///< of the last peer; 0: stays
  bool record = true;
  /// Called before each step with what the nodes are; may interfere.
  std::function<void(Tick, const std::vector<std::unique_ptr<node::RecordedReplica>>&)> before_step;
};

/// The lab's lock step with recorded nodes: what Simulation does, every peer's trace in `traces`.
struct RecordedRun {
  std::vector<std::vector<std::byte>> traces;
  std::vector<std::unique_ptr<node::RecordedReplica>> nodes;

  explicit RecordedRun(const RunConfig& c, bool finish = true)
      : traces(static_cast<std::size_t>(c.peers)),
        scene_(scenarios::load_embedded(c.scenario, c.seed)),
        inputs_(inputs_of(c, scene_)),
        links_(shell::parse_netem(c.netem), c.seed) {
    for (PeerId p = 0; p < c.peers; ++p) {
      nodes.push_back(std::make_unique<node::RecordedReplica>(scene_, config_of(c, p), recording_of(c, p)));
    }
    for (Tick t = 1; t <= c.ticks; ++t) {
      if (t == c.leave_at) nodes.back()->leave();
      if (c.before_step) c.before_step(t, nodes);
      step(t);
    }
    if (finish)
      for (const auto& n : nodes) n->finish();
  }

  static std::vector<std::unique_ptr<scenarios::InputSource>> inputs_of(const RunConfig& c, const Scene& scene) {
    std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
    for (int p = 0; p < c.peers; ++p) inputs.push_back(shell::make_input("wander", {scene, p, c.seed, {}}));
    return inputs;
  }

 private:
  static node::ReplicaConfig config_of(const RunConfig& c, PeerId p) {
    node::ReplicaConfig n;
    n.self = p;
    n.peers = n.slots = c.peers;
    n.session = 1;
    n.technique = p == 1 && c.second_technique ? *c.second_technique : c.technique;
    return n;
  }

  std::optional<node::RecordedReplica::Recording> recording_of(const RunConfig& c, PeerId p) {
    if (!c.record) return std::nullopt;
    trace::Provenance from;
    from.program = "test";
    from.command = {"test", "--run"};
    from.revision = "abc";
    from.scenario = c.scenario;
    from.scenario_text = std::string(scenarios::embedded_text(c.scenario));
    from.scenario_seed = c.seed;
    from.netem = c.netem;
    from.netem_seed = c.seed;
    from.input = "wander";
    return node::RecordedReplica::Recording{
        from, [this, p](std::span<const std::byte> b) { traces[p].insert(traces[p].end(), b.begin(), b.end()); }};
  }

  void step(Tick t) {
    links_.deliver(tick_start(t), [&](std::size_t /*from*/, std::size_t to, Micros /*when*/, const auto& d) {
      nodes[to]->receive(d, tick_start(t));
    });
    for (PeerId p = 0; p < nodes.size(); ++p) {
      nodes[p]->step(inputs_[p]->target(t), 100 * t);
      for (const node::Outgoing& o : nodes[p]->outgoing()) links_.send(p, o.to, tick_start(t), o.bytes);
    }
  }

  Scene scene_;
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs_;
  link::LinkMesh links_;
};

}  // namespace padr::test
