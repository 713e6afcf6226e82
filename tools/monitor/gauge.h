#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/monitor/telemetry.h"
#include "common/trace/metrics.h"

namespace padr::monitor {

/// Inconsistency as it happens: what trace::InconsistencyMeter measures afterwards from traces, measured from the
/// frames that peers tell, at the ticks that they tell them of, as soon as the tick is confirmed. Memory is bounded:
/// what does not get confirmed in time is not measured.
class Gauge {
 public:
  using Measured = std::pair<PeerId, trace::InconsistencyPoint>;

  explicit Gauge(int bodies) : bodies_(bodies) {}

  /// A whole frame with live places.
  void frame(PeerId slot, std::shared_ptr<const Frame> frame);
  /// The agreed world of a tick, by whoever told it first.
  void agreed(std::shared_ptr<const Agreed> agreed);
  /// Who sat there has gone.
  void forget(PeerId slot);

  /// What can be measured since the last call, by ascending tick.
  std::vector<Measured> take();

 private:
  static constexpr std::size_t kTicks = 400;              // that wait, of all peers together
  static constexpr Tick kPatience = kTicksPerSecond / 2;  // until a frame counts as lost
  struct Pending {
    std::map<PeerId, std::shared_ptr<const Frame>> frames;
    std::shared_ptr<const Agreed> agreed;
  };
  /// Agreed worlds come by ascending tick, from each peer: after so many newer ones a tick's is lost.
  static constexpr Tick kPassed = 2 * kTicksPerSecond;
  enum class State : std::uint8_t { kWaits, kReady, kLost };
  State state(Tick tick, const Pending& p) const;
  void measure(Tick tick, const Pending& p, std::vector<Measured>& out) const;
  Pending* at(Tick tick);

  int bodies_;
  std::map<Tick, Pending> pending_;
  Tick done_ = -1;           ///< up to here nothing waits any more
  Tick newest_agreed_ = -1;  ///< of those told
  struct Span {
    Tick first = 0;
    Tick newest = 0;
  };
  std::map<PeerId, Span> spans_;  ///< of frames told
};

}  // namespace padr::monitor
