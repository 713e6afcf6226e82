#pragma once

#include <cstdint>
#include <vector>

#include "common/model/ids.h"

namespace padr::node {

/// Transit times of a link's latest datagrams by the two session clocks, to be shown to people. Clocks are steered by
/// the least transit time alone; see LinkClock.
class Arrivals {
 public:
  struct Delays {
    Micros median = 0;
    Micros p95 = 0;
  };

  /// A datagram stamped with the start of `sent` (the sender's session clock) arrived at `arrived` (ours).
  void sample(Tick sent, Micros arrived);
  /// Delays of the datagrams that came in the 5 s before `now`, the latest 128 at most; if there are none, of the
  /// latest one. Only if any().
  Delays delays(Micros now) const;
  bool any() const { return !ring_.empty(); }

 private:
  static constexpr std::size_t kSamples = 128;
  static constexpr Micros kSpan = 5 * kMicrosPerSecond;
  struct Sample {
    Micros arrived;
    Micros transit;
  };
  std::vector<Sample> ring_;  ///< the first datagram allocates all of its memory
  std::size_t next_ = 0;      ///< where the next one goes
};

}  // namespace padr::node
