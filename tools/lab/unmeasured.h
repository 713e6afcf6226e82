#pragma once

#include <string>

#include "common/model/ids.h"

namespace padr::lab {

/// One line on standard error if inconsistency was measured at so small a share, 0 to 1, of so many ticks that a mean
/// is that of the beginning: see Simulation::is_little(). `runs` says of which.
void warn_of_unmeasured(const std::string& runs, double share, Tick ticks);

}  // namespace padr::lab
