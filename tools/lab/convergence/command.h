#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/support/netem_flags.h"
#include "tools/support/scenario_flags.h"

namespace padr::lab {

/// `padr-lab convergence`: one session, shown by every method of convergence, as figures and as a film.
class ConvergenceCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code. Throws UserError.
  int run();

 private:
  support::ScenarioFlags scenario_;
  support::NetemFlags netem_;
  int peers_ = 4;
  double seconds_ = 60;
  std::string out_;
};

}  // namespace padr::lab
