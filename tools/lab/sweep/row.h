#pragma once

#include <string>

#include "tools/lab/sweep/grid.h"

namespace padr::lab::sweep {

/// The heading of a grid's CSV: `grid`, `run` and `of` (which run of how many), what the run is, and what came of it,
/// everything for all peers together. Without a newline.
std::string heading_of(const Grid& grid);

/// Runs point `index` of the grid, and returns its line of CSV without a newline. The same grid and index give the same
/// line, to the byte. Throws UserError, for bodies there is no room for with this seed.
std::string run_point(const Grid& grid, std::size_t index);

}  // namespace padr::lab::sweep
