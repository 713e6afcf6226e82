#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/lab/simulation.h"

namespace padr::lab {

/// What a run says of itself besides the simulation.
struct RunFacts {
  std::vector<std::string> command;
  std::string scenario;
  std::string netem;
  std::vector<std::string> inputs;
  std::uint64_t seed = 0;
  std::uint64_t netem_seed = 0;
  Technique technique;
  double wall_seconds = 0;
  std::optional<PeerId> watched;  ///< only what this peer sees counts, and only while there is input
};

std::string json_summary(const Simulation& s, const RunFacts& facts);
std::string table_summary(const Simulation& s, const RunFacts& facts);
/// tick,peer,avatars_m,bodies_m,combined_m,shown_m, and with fidelity fidelity_m,pcc_m,pcc_bodies
std::string csv_series(const Simulation& s);

}  // namespace padr::lab
