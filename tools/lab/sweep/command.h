#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/lab/sweep/grid.h"

namespace padr::lab {

/// `padr-lab sweep`: a grid of runs into one CSV.
class SweepCommand {
 public:
  SweepCommand();
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if confirmed worlds differed. Throws UserError.
  int run();

 private:
  sweep::GridText grid_;
  std::string csv_;
  std::string summary_;
  std::string shard_;
  int jobs_ = 0;
  bool dry_ = false;
};

/// `padr-lab merge`: the CSVs of a sweep's shards into one.
class MergeCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code. Throws UserError.
  int run();

 private:
  std::vector<std::string> shards_;
  std::string out_;
  std::string summary_;
};

}  // namespace padr::lab
