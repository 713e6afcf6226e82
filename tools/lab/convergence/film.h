#pragma once

#include "tools/lab/convergence/footage.h"
#include "tools/plot/film_strip.h"

namespace padr::lab::convergence {

/// The largest correction of an avatar and of a body, a row each, as the viewer is shown it by every method, a column
/// each. Rows are left out if there is none. `scene` is what was played in.
plot::FilmStrip film_of(const Footage& footage, const Scene& scene);

}  // namespace padr::lab::convergence
