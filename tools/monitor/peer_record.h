#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/monitor/telemetry.h"
#include "tools/monitor/pieces.h"

namespace padr::monitor {

/// Per second, over the last second or two.
struct PeerRates {
  std::array<double, sync::kCauses> updates_per_s{};
  double datagrams_per_s = 0;
  double kbit_per_s = 0;
  double replayed_per_tick = 0;
};

/// Turns counters into rates.
class RateMeter {
 public:
  void take(const Status& s);
  /// Nothing before there have been two statuses.
  const std::optional<PeerRates>& rates() const { return rates_; }

 private:
  static constexpr Tick kSpan = kTicksPerSecond;
  std::deque<Status> window_;  ///< without their links
  std::optional<PeerRates> rates_;
};

/// All that a process has told.
struct PeerRecord {
  enum class Presence : std::uint8_t { kHere, kSilent, kGone };

  explicit PeerRecord(const Origin& o) : origin(o) {}
  Presence presence(Micros now) const;
  /// Milliseconds by which confirmed trails; nothing if that is not known.
  std::optional<double> lag_ms() const;
  /// Nothing of who is not here, or stands still.
  std::optional<PeerRates> current_rates(Micros now) const;
  bool paused() const { return status && status->paused; }

  Origin origin;
  Endpoint from;  ///< where its datagrams come from: where orders go
  Micros first_heard = 0;
  Micros heard = 0;
  Micros ended_at = -1;  ///< -1: it has not said that it ends
  std::optional<Hello> hello;
  std::optional<Status> status;        ///< the newest, without its links
  std::map<PeerId, LinkStatus> links;  ///< as last told of each
  RateMeter rates;
  Pieces<Frame> frame_pieces;
  Pieces<Agreed> agreed_pieces;
  std::shared_ptr<const Frame> newest;
  std::uint64_t frames = 0;  ///< that came whole
  std::uint64_t lost = 0;    ///< that should have come
  std::uint32_t last_event = 0;

  static constexpr Micros kSilentAfter = kMicrosPerSecond;
  static constexpr Micros kGoneAfter = 5 * kMicrosPerSecond;
};

/// Of 0 .. `upto`, how many ticks have a frame at this rate.
constexpr std::int64_t frames_until(Tick upto, int rate) {
  return static_cast<std::int64_t>(upto) * rate / kTicksPerSecond;
}

}  // namespace padr::monitor
