#pragma once

#include <chrono>

#include "common/model/ids.h"

namespace padr::shell {

/// A program's only clock: microseconds since it began, monotonic.
class Clock {
 public:
  using Steady = std::chrono::steady_clock;
  Micros now() const { return std::chrono::duration_cast<std::chrono::microseconds>(Steady::now() - start_).count(); }
  Steady::time_point at(Micros t) const { return start_ + std::chrono::microseconds(t); }

 private:
  Steady::time_point start_ = Steady::now();
};

}  // namespace padr::shell
