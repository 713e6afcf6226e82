#pragma once

#include "common/world/fingerprint.h"

namespace padr::world {

/// Each Habit that this build has on this machine, as a sum of their bits. Found out by computing, not by what the
/// compiler says of itself: whatever flags and libraries there are, it is the results that count.
unsigned own_habits();

}  // namespace padr::world
