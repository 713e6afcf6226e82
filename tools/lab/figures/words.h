#pragma once

#include <cmath>
#include <string>

#include "shell/text.h"

namespace padr::lab::figures {

/// Fixed digits; "-" for what there is no number for.
inline std::string fixed(double v, int digits) {
  return shell::fixed_or_dash(v, digits);
}

/// 0.5 is "50 %".
inline std::string percent(double v) {
  return std::isfinite(v) ? fixed(100 * v, 0) + " %" : "-";
}

}  // namespace padr::lab::figures
