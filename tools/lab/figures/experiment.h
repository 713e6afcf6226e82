#pragma once

#include <string>
#include <vector>

#include "tools/lab/figures/measures.h"
#include "tools/lab/figures/run.h"
#include "tools/lab/parallel.h"

namespace padr::lab::figures {

/// What is to be run: every case with every setting.
struct Plan {
  std::string scenario;  ///< as the flag was written
  std::vector<Case> cases;
  std::vector<Setting> settings;
  link::NetemSpec netem;
  std::string netem_text;
  Tick ticks = 0;
  /// The command line that gives these results again, without where they go and how many run at once.
  std::string command;
  double seconds() const { return static_cast<double>(ticks) / kTicksPerSecond; }
};

/// What came of it, by case, then by setting.
struct Results {
  std::vector<std::vector<FigureRun>> runs;
  std::vector<std::vector<Measures>> measures;
};

Results run_plan(const Plan& plan, const ParallelOptions& parallel);

/// The kinds of input that there are, in the order of the cases.
std::vector<std::string> kinds_of(const Plan& plan);

/// One number of every case's run with a setting; of the cases with one kind of input if it is given.
std::vector<double> over_cases(const Plan& plan, const Results& results, const std::string& setting,
                               double (*number)(const Measures&), const std::string& kind = "");
double mean_of(const std::vector<double>& values);
/// The sum over all cases.
PredictionScore score_of(const Plan& plan, const Results& results, const std::string& setting);

}  // namespace padr::lab::figures
