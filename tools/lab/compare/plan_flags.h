#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/lab/compare/comparison.h"

namespace padr::lab::compare {

/// The flags that say what is played: contestants, networks, inputs and seeds.
class PlanFlags {
 public:
  /// What is played if nothing else is said.
  struct Usual {
    std::string techniques;
    int seeds = 1;
    std::vector<std::string> networks;
  };
  explicit PlanFlags(Usual usual) : usual_(std::move(usual)), seeds_(usual_.seeds), techniques_(usual_.techniques) {}

  void declare(CLI::App& app);
  /// After parsing. Throws UserError for all that the runs would refuse, too.
  Plan plan() const;

 private:
  Usual usual_;
  std::string scenario_ = "arena";
  int peers_ = 4;
  double seconds_ = 30;
  int seeds_;
  std::vector<std::string> netem_;
  std::vector<std::string> inputs_;
  std::string techniques_;
  std::vector<std::string> added_;
  int jobs_ = 0;
};

/// All contestants, a line each, and the knobs of alternatives.
std::string help_on_contestants();

}  // namespace padr::lab::compare
