#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "tools/lab/audit/audit.h"
#include "tools/lab/testbed/virtual_network.h"

namespace padr::test {

/// Keeps the trace of every life of a virtual network's persons.
class Recorder {
 public:
  /// `bodies` 0: as many as the scenario has.
  Recorder(const std::string& scenario, std::uint64_t seed, std::uint32_t bodies = 0) {
    from_.scenario = scenario;
    from_.scenario_text = std::string(scenarios::embedded_text(scenario));
    if (bodies > 0) from_.scenario_text = scenarios::with_bodies(from_.scenario_text, scenario, bodies);
    from_.scenario_seed = seed;
  }

  Scene scene() const { return scenarios::load(from_.scenario_text, from_.scenario, from_.scenario_seed); }
  auto hook() {
    return [this](int person, int life) -> std::optional<node::RecordedReplica::Recording> {
      std::vector<std::byte>& into = traces_[{person, life}];
      into.clear();
      return node::RecordedReplica::Recording{
          from_, [&into](std::span<const std::byte> b) { into.insert(into.end(), b.begin(), b.end()); }};
    };
  }

  /// All but those of some persons.
  std::vector<lab::audit::TraceText> traces(const std::set<int>& but = {}) const {
    std::vector<lab::audit::TraceText> all;
    for (const auto& [key, bytes] : traces_)
      if (!but.contains(key.first))
        all.push_back({"person" + std::to_string(key.first) + "." + std::to_string(key.second) + ".trace", bytes});
    return all;
  }

 private:
  trace::Provenance from_;
  std::map<std::pair<int, int>, std::vector<std::byte>> traces_;  ///< by person, life
};

/// What was found, one line each.
inline std::string lines(const lab::audit::Report& r) {
  std::string all;
  for (const lab::audit::Finding& f : r.findings)
    all += "slot " + std::to_string(r.evidence.members[f.who].slot) + "." +
           std::to_string(r.evidence.members[f.who].incarnation) + " tick " + std::to_string(f.tick) + " " +
           std::string(lab::audit::kKindNames[static_cast<std::size_t>(f.kind)]) + " body " + std::to_string(f.body) +
           ": " + std::to_string(f.measured) + " of " + std::to_string(f.allowed) + " " + f.what + " in " +
           r.labels[f.traces.front()] + "\n";
  return all;
}

}  // namespace padr::test
