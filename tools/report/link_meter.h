#pragma once

#include <cstdint>
#include <vector>

#include "tools/report/report.h"

namespace padr::report {

/// What a directed link did to the datagrams that its sender's trace says were sent on it, by the receiver's trace.
class LinkMeter {
 public:
  void sent(std::uint32_t seq, Tick tick);
  void received(std::uint32_t seq, Tick mark, Micros at);

  /// `receiver_end`: the last tick of the receiver's trace. Datagrams of its last second may still be on their way and
  /// are not judged lost.
  Link result(PeerId from, PeerId to, Tick receiver_end) const;

 private:
  struct Departure {
    std::uint32_t seq;
    Tick tick;
  };
  struct Arrival {
    std::uint32_t seq;
    double delay_ms;
  };
  std::vector<Departure> departures_;
  std::vector<Arrival> arrivals_;
};

}  // namespace padr::report
