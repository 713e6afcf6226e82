#pragma once

#include <cstdint>
#include <vector>

#include "common/model/ids.h"

namespace padr::node {

/// How long a link's latest datagrams were on their way, by the two session clocks: what people want to know of a link.
/// (Clocks are steered by the least alone; see LinkClock.)
class Arrivals {
 public:
  struct Delays {
    Micros median = 0;
    Micros p95 = 0;
  };

  /// A datagram stamped with the start of `sent` (the sender's session clock) arrived at `arrived` (ours).
  void sample(Tick sent, Micros arrived);
  /// Of those that came in the 5 s before `now`, the latest 128 at most; of the very latest one if there are none. Only
  /// when something has come.
  Delays delays(Micros now) const;
  bool any() const { return !ring_.empty(); }

 private:
  static constexpr std::size_t kSamples = 128;
  static constexpr Micros kSpan = 5 * kMicrosPerSecond;
  struct Sample {
    Micros arrived;
    Micros transit;
  };
  std::vector<Sample> ring_;  ///< takes its memory with the first datagram, all of it
  std::size_t next_ = 0;      ///< where the next one goes
};

}  // namespace padr::node
