#pragma once

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
};

std::string json_summary(const Simulation& s, const RunFacts& facts);
std::string table_summary(const Simulation& s, const RunFacts& facts);
/// tick,peer,avatars_m,bodies_m,combined_m,shown_m
std::string csv_series(const Simulation& s);

}  // namespace padr::lab
