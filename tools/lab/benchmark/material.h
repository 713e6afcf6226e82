#pragma once

#include <string>

#include "tools/lab/compare/comparison.h"

namespace padr::lab::benchmark {

/// Writes what others need to play the same: DIR/inputs/seedS-peerP.csv, where each hand is at each tick (t,x,y in s
/// and m), and DIR/links/NAME.link, the link traces that the networks name. Throws UserError that names --out.
void write_material(const compare::Plan& plan, const std::string& dir);

}  // namespace padr::lab::benchmark
