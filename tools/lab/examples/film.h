#pragma once

#include "tools/lab/examples/measure.h"
#include "tools/plot/film_strip.h"

namespace padr::lab::examples {

/// Both views of a story's first take as a film strip: what truly happens in the uppermost row, and below what the
/// other peer believes at the same moments under every one of `techniques`, by name.
plot::FilmStrip film_of(const Story& story, const std::vector<std::pair<std::string, Technique>>& techniques,
                        const link::NetemSpec& netem);

}  // namespace padr::lab::examples
