#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "shell/netem_flags.h"
#include "shell/scenario_flags.h"

namespace padr::lab {

/// `padr-lab convergence`: one session, shown by every method of convergence, as figures and as a film.
class ConvergenceCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code. Throws UserError.
  int run();

 private:
  shell::ScenarioFlags scenario_;
  shell::NetemFlags netem_;
  int peers_ = 4;
  double seconds_ = 60;
  std::string out_;
};

}  // namespace padr::lab
