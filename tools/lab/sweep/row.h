#pragma once

#include <string>

#include "tools/lab/sweep/grid.h"

namespace padr::lab::sweep {

/// The heading of a grid's CSV: `grid`, `run` and `of` (which run of how many), what the run is, and what came of it,
/// everything for all peers together. Without a newline.
std::string heading_of(const Grid& grid);

struct Row {
  std::string text;           ///< one line of CSV without its newline
  double measured_share = 1;  ///< of ticks, of those with inconsistency
};

/// Runs point `index` of the grid. The same grid and index give the same row, to the byte. Throws UserError, for bodies
/// there is no room for with this seed.
Row run_point(const Grid& grid, std::size_t index);

}  // namespace padr::lab::sweep
