#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "shell/technique_flags.h"
#include "tools/lab/crowd/body_positions.h"

namespace padr::lab {

/// What a crowd of one size cost and was worth, per peer where not said otherwise.
struct CrowdRow {
  int peers = 0;
  int crowds = 1;           ///< that it is the mean of; what is counted is their sum
  std::size_t regions = 0;  ///< in all
  double regions_each = 0;
  double members = 0;  ///< of a region
  double links = 0;    ///< receivers spoken to within a second
  double updates = 0;  ///< 1/s
  double kbps = 0;     ///< sent, headers included
  double cpu_us = 0;   ///< a tick
  int inner = 0;       ///< who stroll well within the crowd's ground; of them:
  double inner_kbps = 0;
  double inner_cpu_us = 0;
  double neighbours = 0;
  double avatars_m = 0;
  double per_avatar_m = 0;
  double bodies_m = 0;
  double unseen = 0;     ///< 0 .. 1
  double handovers = 0;  ///< 1/s
  double entered = 0;    ///< regions, 1/s
  double late = 0;       ///< share of ticks with the avatar in a region that it is not in yet
  std::uint64_t failed = 0;
  std::uint64_t bodies_over = 0;  ///< entries said
  BodyPositions bodies;           ///< at the end
  std::uint64_t compared = 0;
  std::uint64_t different = 0;
  std::uint64_t confirmed = 0;  ///< ticks of regions
  std::uint64_t split = 0;      ///< of these, on several sides
};

/// `padr-lab crowd`: crowds of several sizes at the same density.
class CrowdCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if confirmed worlds differed. Throws UserError.
  int run(const std::vector<std::string>& command);

 private:
  class Watched;
  struct Size;
  Size begin(int peers) const;
  std::vector<CrowdRow> measure() const;
  CrowdRunConfig config_of(int peers, std::uint64_t seed) const;
  std::string json(const std::vector<std::string>& command, const std::vector<CrowdRow>& rows) const;

  shell::TechniqueFlags technique_;
  std::string peers_text_ = "4,50,200";
  std::vector<int> peers_;
  double seconds_ = 20;
  double warm_up_ = 4;
  double arrivals_ = 20;
  std::uint64_t seed_ = 1;
  std::string netem_ = "delay 100ms loss 2%";
  double room_ = 144;
  double near_ = 5;
  crowd::Plane plane_;
  bool uniform_ = false;
  double shoves_ = 0;
  int fill_ = 0;
  int jobs_ = 1;
  std::string json_;
};

}  // namespace padr::lab
