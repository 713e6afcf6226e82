#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/lab/compare/comparison.h"
#include "tools/lab/sweep/sweep.h"

namespace padr::lab::benchmark {

/// A comparison whose runs go to a file one by one, so that it can be stopped and goes on where it was. Runs are in the
/// order of compare::run_plan: seeds change fastest, networks slowest.
class Benchmark {
 public:
  /// Reads what the plan names, and throws UserError if that does not work.
  explicit Benchmark(compare::Plan plan);

  const compare::Plan& plan() const { return plan_; }
  /// Eight hexadecimal digits: of all that the results depend on, the program's revision and this machine's physics
  /// included.
  const std::string& id() const { return id_; }
  std::size_t size() const { return plan_.networks.size() * plan_.contestants.size() * plan_.seeds.size(); }

  /// Runs what `file` does not have yet. Throws UserError that names --out if the file is another benchmark's.
  sweep::SweepResult run(const std::string& file) const;
  /// All results, from the file. Throws UserError that names --out, file and line for one that is damaged or not
  /// complete.
  std::vector<compare::Row> rows(const std::string& file) const;

 private:
  struct Place {
    const compare::Network* network;
    const compare::Contestant* who;
    std::uint64_t seed;
  };
  Place place(std::size_t run) const;
  std::string identify() const;
  std::string heading() const;
  std::string play(std::size_t run) const;

  compare::Plan plan_;
  std::string id_;
};

}  // namespace padr::lab::benchmark
