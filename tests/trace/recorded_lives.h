#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/scenarios/scenarios.h"
#include "shell/netem_text.h"
#include "tools/lab/testbed/virtual_network.h"

namespace padr::test {

/// Of each person's every incarnation.
using Traces = std::map<std::pair<int, int>, std::vector<std::byte>>;

/// For VirtualNetworkConfig::recording. `traces` has to outlive the network.
inline auto record_into(Traces& traces, const trace::Provenance& from) {
  return [&traces, from](int person, int incarnation) -> std::optional<node::RecordedReplica::Recording> {
    trace::Provenance of = from;
    of.start_unix_us = 1 + person;
    std::vector<std::byte>& into = traces[{person, incarnation}];
    into.clear();
    return node::RecordedReplica::Recording{
        of, [&into](std::span<const std::byte> b) { into.insert(into.end(), b.begin(), b.end()); }};
  };
}

/// A session that people join late, vanish from, are cut off from and come back to, on virtual time, with the trace of
/// each person's every incarnation.
struct RecordedLives {
  using Key = Traces::key_type;
  Traces traces;

  /// Persons 0, 1 and 2 begin together; 3 comes late, 1 is killed; 2 and 4 are cut off and come back; the founder
  /// leaves.
  explicit RecordedLives(std::uint64_t seed, wire::SealMode seal = wire::SealMode::kNone) {
    lab::VirtualNetwork g(config(seed, seal));
    const auto run = [&g](double s) { g.run_to(g.now() + static_cast<Micros>(s * 1e6)); };
    g.start({});
    g.start(0);
    g.start(0);
    run(5);
    g.start(2);
    run(3);
    g.kill(1);
    g.start(0);
    run(7);
    g.divide({{2, 1}});
    run(7);
    g.divide({});
    run(5);
    g.leave(0);
    run(5);
    g.finish();
  }

  std::string label(Key k) const {
    return "person" + std::to_string(k.first) + (k.second == 0 ? "" : "." + std::to_string(k.second + 1)) + ".trace";
  }

 private:
  lab::VirtualNetworkConfig config(std::uint64_t seed, wire::SealMode seal) {
    lab::VirtualNetworkConfig c;
    c.seal = seal;
    c.scene = scenarios::load_embedded("arena", seed);
    c.technique = technique_by_name("full");
    c.netem = shell::parse_netem("delay 40ms 15ms loss 3%");
    c.seed = seed;
    c.slots = 6;
    c.wanted = 3;
    trace::Provenance from;
    from.scenario = "arena";
    from.scenario_text = std::string(scenarios::embedded_text("arena"));
    from.scenario_seed = seed;
    c.recording = record_into(traces, from);
    return c;
  }
};

}  // namespace padr::test
