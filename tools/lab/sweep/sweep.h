#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/lab/parallel.h"
#include "tools/lab/sweep/grid.h"

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
  bool agreed = true;        ///< no two confirmed worlds differed in the runs done now
};

/// Runs what the file does not have yet of the shard's runs. Rows are added as they are done; in the end the file is in
/// canonical form, the same whatever was done when. Throws UserError, which names --csv, if the file has rows of
/// another grid or shard.
SweepResult run_sweep(const Grid& grid, const Shard& shard, const std::string& file, const ParallelOptions& parallel);

/// Joins the files of all shards into `out`, which becomes byte for byte what one unsharded sweep writes. Returns the
/// number of runs. Throws UserError, which names the files, if shards are of different grids, or a run is there twice
/// or not at all.
std::size_t merge(const std::vector<std::string>& shards, const std::string& out);

}  // namespace padr::lab::sweep
