#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/lab/compare/plan_flags.h"

namespace padr::lab {

/// `padr-lab compare`: techniques side by side on the same inputs, seeds and links.
class CompareCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if confirmed worlds differed. Throws UserError.
  int run(const std::vector<std::string>& command) const;

 private:
  compare::PlanFlags flags_{
      {.techniques = "all", .seeds = 40, .networks = {"delay 0ms", "delay 50ms", "delay 100ms", "delay 250ms"}}};
  bool processor_time_ = false;
  std::string json_;
  std::string csv_;
  std::string out_;
};

}  // namespace padr::lab
