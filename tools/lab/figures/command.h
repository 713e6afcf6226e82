#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "shell/netem_flags.h"
#include "shell/scenario_flags.h"
#include "tools/lab/figures/experiment.h"

namespace padr::lab {

/// `padr-lab figures`: the paper's experiments, over several inputs and seeds.
class FiguresCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code. Throws UserError.
  int run();

 private:
  figures::Plan plan() const;
  std::string canonical() const;
  std::vector<figures::Setting> settings() const;

  shell::ScenarioFlags scenario_;
  std::vector<std::string> inputs_;
  std::vector<std::string> knobs_;  ///< by shell::knobs(); empty: as the setting has it
  std::vector<std::string> added_;
  std::string out_;
  int seeds_ = 6;
  double seconds_ = 60;
  int jobs_ = 0;
  std::string netem_;
  bool no_pictures_ = false;
};

}  // namespace padr::lab
