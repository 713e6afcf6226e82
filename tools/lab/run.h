#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "shell/netem_flags.h"
#include "shell/scenario_flags.h"
#include "shell/technique_flags.h"
#include "tools/lab/simulation.h"

namespace padr::lab {

/// `padr-lab run`: one session from flags to summary.
class RunCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if confirmed worlds differed. Throws UserError.
  int run(const std::vector<std::string>& command);

 private:
  void prepare_outputs(const shell::LoadedScenario& scenario, const std::vector<std::string>& command,
                       SimulationConfig& config);

  shell::ScenarioFlags scenario_;
  shell::TechniqueFlags technique_;
  shell::NetemFlags netem_;
  int peers_ = 2;
  int slots_ = 0;
  double seconds_ = 60;
  double settle_seconds_ = 0;
  int watch_ = -1;
  std::vector<std::string> inputs_;
  std::string fidelity_ = "on";
  std::string json_;
  std::string trace_dir_;
  std::string series_;
};

}  // namespace padr::lab
