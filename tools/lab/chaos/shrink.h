#pragma once

#include "tools/lab/chaos/play.h"

namespace padr::lab {

/// A script that still goes wrong though nothing more can be left out of it one by one; at most `tries` are played.
ChaosScript shrink(const ChaosPlay& how, const ChaosScript& script, int tries);

}  // namespace padr::lab
