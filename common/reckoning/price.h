#pragma once

#include <cmath>

namespace padr::sync {

/// What a byte costs now: thresholds are multiplied by it. At price 1 whatever the thresholds ask for is told. The
/// price rises with what was sent ahead of what is meant to be sent, and falls as that time passes: errors that are
/// told then are those worth most, and as many as the links and the budget take. `ahead`: s, from 0 to
/// LinkRate::kMostAhead, on the link that has most. From 1 to 47.
inline float price_of(double ahead) {
  const auto a = static_cast<float>(1 + ahead);
  return a * a * a * std::sqrt(a);
}

}  // namespace padr::sync
