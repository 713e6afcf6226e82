#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "common/model/ids.h"

namespace padr::node {

/// Least transit time of a link's recent datagrams by the two session clocks: delay plus the difference of the clocks.
/// The minimum is the sample that queueing disturbed least. It covers a sliding span, so that it follows drift.
class LinkClock {
 public:
  /// A datagram stamped with the start of `sent` (the sender's session clock) arrived at `arrived` (ours).
  void sample(Tick sent, Micros arrived) {
    const Micros transit = arrived - tick_start(sent);
    if (arrived - span_start_ > kSpan) {
      previous_ = current_;
      current_ = kNone;
      span_start_ = arrived;
    }
    current_ = std::min(current_, transit);
  }
  void told(std::int32_t tenth_ms) {
    theirs_ = static_cast<Micros>(tenth_ms) * 100;
    heard_ = true;
  }

  bool measured() const { return least() != kNone; }
  /// Microseconds; only when measured.
  Micros least() const { return std::min(previous_, current_); }
  /// Whether both have measured.
  bool compared() const { return measured() && heard_; }
  /// Least round trip of recent datagrams, us: the clocks' difference cancels out. 0 until both have measured.
  Micros round_trip() const { return compared() ? std::max<Micros>(0, least() + theirs_) : 0; }
  /// By how much our clock leads theirs, if delays are alike both ways; 0 until both have measured.
  Micros lead() const { return compared() ? (least() - theirs_) / 2 : 0; }
  /// By how much it leads theirs at least, whatever the delays are; negative or 0 if that is not known.
  Micros least_lead() const { return heard_ ? -theirs_ : 0; }
  /// By how much it is behind theirs at least, likewise: a datagram has come before it was sent.
  Micros least_lag() const { return measured() ? -least() : 0; }

 private:
  static constexpr Micros kNone = std::numeric_limits<Micros>::max();
  static constexpr Micros kSpan = 3 * kMicrosPerSecond;
  Micros previous_ = kNone;
  Micros current_ = kNone;
  Micros span_start_ = 0;
  Micros theirs_ = 0;
  bool heard_ = false;
};

}  // namespace padr::node
