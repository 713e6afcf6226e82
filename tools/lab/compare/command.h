#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/lab/compare/comparison.h"

namespace padr::lab {

/// `padr-lab compare`: techniques side by side on the same inputs, seeds and links.
class CompareCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if confirmed worlds differed. Throws UserError.
  int run(const std::vector<std::string>& command) const;

 private:
  compare::Plan plan() const;

  std::string scenario_ = "arena";
  int peers_ = 4;
  double seconds_ = 30;
  int seeds_ = 40;
  std::vector<std::string> netem_;
  std::vector<std::string> inputs_;
  std::string techniques_ = "all";
  std::vector<std::string> added_;
  bool processor_time_ = false;
  int jobs_ = 0;
  std::string json_;
  std::string csv_;
  std::string out_;
};

}  // namespace padr::lab
