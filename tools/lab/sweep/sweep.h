#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tools/lab/parallel.h"
#include "tools/lab/sweep/grid.h"
#include "tools/lab/sweep/row.h"

namespace padr::lab::sweep {

/// Which runs of a grid are whose: shard `index` of `count` has every count-th run, from its own one on.
struct Shard {
  std::size_t index = 1;  ///< 1 .. count
  std::size_t count = 1;
  bool has(std::size_t run) const { return run % count == index - 1; }
};

/// "I/N". Throws UserError that names --shard.
Shard shard_of(const std::string& text);

struct SweepResult {
  std::size_t runs = 0;      ///< of the shard
  std::size_t done_now = 0;  ///< the rest was in the file already
};

/// Runs of which each gives a row of a CSV file.
struct Runs {
  std::string id;  ///< runs of one number and one id give the same row; stands in every row
  std::size_t size = 0;
  std::string heading;  ///< without a newline; begins grid,run,of
  std::function<std::string(std::size_t)> row;
  std::string flag = "--csv";  ///< for messages
};

/// Runs what the file does not have yet of the shard's runs. Rows are added as they are done; in the end the file is in
/// canonical form, whatever was done when. Throws UserError, which names the flag, if the file has rows of other runs,
/// or another process is writing it.
SweepResult run_missing(const Runs& runs, const Shard& shard, const std::string& file, const ParallelOptions& parallel);

/// The same of a grid, whose file is the same to the byte each time.
SweepResult run_sweep(const Grid& grid, const Shard& shard, const std::string& file, const ParallelOptions& parallel);

/// Joins the files of all shards into `out`, which becomes byte for byte what one unsharded sweep writes. Returns the
/// number of runs. Throws UserError, which names the files, if shards are of different grids, or a run is there twice
/// or not at all.
std::size_t merge(const std::vector<std::string>& shards, const std::string& out);

}  // namespace padr::lab::sweep
