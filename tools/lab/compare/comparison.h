#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/lab/compare/trial.h"
#include "tools/lab/parallel.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab::compare {

struct Plan {
  std::vector<Contestant> contestants;
  std::vector<Network> networks;
  Setting setting;
  std::vector<std::uint64_t> seeds;
  ParallelOptions parallel;
};

/// A figure over several seeds.
struct Figure {
  double mean = 0;
  double low = 0;
  double high = 0;
  double error = 0;  ///< standard error of the mean; 0 for a single seed
};

/// One contestant on one network.
struct Row {
  Contestant who;
  std::string network;
  std::vector<Score> scores;  ///< by seed
  /// Over the seeds whose score has it, of any field of a score; all 0 if none has.
  Figure over(double (*field)(const Score&), bool (*has)(const Score&) = has_any) const;
  double mean_m() const;  ///< m, mean combined inconsistency against now
  double kbps() const;    ///< per peer
  /// Mean over the seeds of processor time, in steps of a bare world; nothing if it was not measured.
  std::optional<double> processor_steps() const;
};

/// All runs; rows network by network, contestants in the order of the plan.
std::vector<Row> run_plan(const Plan& plan);

/// How a row stands to `full` on the same network.
enum class Standing : std::uint8_t {
  kIsFull,
  kNoFull,    ///< full is not among the rows
  kWorse,     ///< less of neither: full is better in both
  kTrades,    ///< less of one, more of the other
  kDominates  ///< less of both
};
Standing standing(const Row& row, const std::vector<Row>& rows);

/// The least mean inconsistency (m) that `full` has on the row's network at a budget with which it sends no more than
/// the row does; nothing if every one of those played sends more.
std::optional<double> full_for_no_more(const Row& row, const std::vector<Row>& rows);

/// A warning on standard error for each row that is mostly not measured, see lab::warn_of_unmeasured().
void warn_of_unmeasured(const std::vector<Row>& rows, Tick ticks);

/// A sentence that names those rows of a network, and at which part of the ticks each is measured; empty if there are
/// none.
std::string little_measured(const std::vector<Row>& rows, const std::string& network, Tick ticks);

std::string table(const std::vector<Row>& rows, const Plan& plan);
std::string json(const std::vector<Row>& rows, const Plan& plan, const std::string& command);
/// One line for each run.
std::string csv(const std::vector<Row>& rows, const Plan& plan);
/// The name, without ending, of the picture of a network.
std::string frontier_name(const std::string& network);
/// Draws frontier_NETWORK, hands_NETWORK (against hands) and ablations_NETWORK, as .svg and .png, into `dir`, which
/// exists.
plot::Drawing draw_frontiers(const std::vector<Row>& rows, const Plan& plan, const std::string& dir);

}  // namespace padr::lab::compare
