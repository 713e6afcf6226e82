#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/lab/compare/plan_flags.h"

namespace padr::lab {

/// `padr-lab benchmark`: all contestants on stated inputs and links, with everything that is measured, into a folder.
class BenchmarkCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if confirmed worlds differed. Throws UserError.
  int run(const std::vector<std::string>& command) const;

 private:
  compare::PlanFlags flags_{
      {.techniques = "frontier",
       .seeds = 3,
       .networks = {"delay 0ms", "delay 50ms", "delay 100ms", "delay 250ms", "delay 100ms 50ms loss 10%",
                    "delay 30ms trace mobile", "delay 30ms trace satellite", "delay 30ms trace uplink"}}};
  std::string out_;
  bool dry_ = false;
};

}  // namespace padr::lab
