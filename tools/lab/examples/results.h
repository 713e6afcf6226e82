#pragma once

#include <string>
#include <vector>

#include "tools/lab/examples/measure.h"
#include "tools/lab/examples/variant.h"
#include "tools/lab/examples/verdict.h"
#include "tools/lab/parallel.h"
#include "tools/plot/plot.h"

namespace padr::lab::examples {

struct Plan {
  std::vector<std::string> stories;
  int takes = 8;  ///< of each story, >= 1
  link::NetemSpec netem;
  std::string netem_text;
  ParallelOptions parallel;
};

/// One story under one variant.
struct Result {
  std::string story;
  std::size_t bodies = 0;  ///< of the story's scene
  Variant variant;
  std::vector<Cost> takes;
  Cost mean;  ///< over the takes
};

/// The story `dominoes` with `count` of them.
struct RowOfDominoes {
  int count = 0;
  Cost without_authority;  ///< means over the takes
  Cost with_authority;
};

struct Results {
  std::vector<Result> results;      ///< by story, then in the order of variants()
  std::vector<Verdict> verdicts;    ///< by story, then by predictor
  std::vector<RowOfDominoes> rows;  ///< 1 to 20, if dominoes are among the stories
};

Results run_plan(const Plan& plan);

/// What a hit of the first domino costs per domino: the slope of the least-squares line of the cost in the end
/// over the number of dominoes, m, and how well it fits (R squared, 0 .. 1).
struct Line {
  double slope_m = 0;
  double r_squared = 0;
};
Line cost_per_domino(const std::vector<RowOfDominoes>& rows);

std::string table(const Results& r, const Plan& plan);
std::string json(const Results& r, const Plan& plan, const std::string& command);
/// One line per story and variant, means over the takes.
std::string csv(const Results& r);
/// One line per story, variant and take.
std::string takes_csv(const Results& r);
/// One line per story and predictor: what it was worth.
std::string verdicts_csv(const Results& r);
/// Cost over the number of dominoes.
plot::LinePlot dominoes_plot(const Results& r);

}  // namespace padr::lab::examples
