#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/scenarios/path.h"
#include "shell/scenario_flags.h"

namespace padr::lab {

/// `padr-lab path`: recorded motion in other units fitted to a scenario, or made-up motion as a path.
class PathCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code. Throws UserError.
  int run(const std::vector<std::string>& command) const;

 private:
  scenarios::Path converted(const Scene& scene) const;
  scenarios::Path made(const Scene& scene) const;

  shell::ScenarioFlags scenario_;
  std::string in_;
  std::string units_ = "m,s";
  std::string input_;
  double seconds_ = 20;
  int rate_ = 20;
  double stretch_ = 1;
  std::string out_;
};

}  // namespace padr::lab
