#pragma once

#include <cstddef>
#include <deque>

#include "common/model/ids.h"

namespace padr::node {

/// Estimates how far another clock is ahead of ours, from repeated requests for its time.
///
/// A request bounds the difference from both sides: the reply was sent after our request and before it arrived. The
/// estimate is the middle of the tightest bounds, each way's least delay by itself, so one lucky datagram each way is
/// enough, whatever queues and jitter did to the others. The error left is half the difference of the least delays.
class OffsetEstimator {
 public:
  /// All in microseconds; `sent` and `received` by our clock, `theirs` by the other. received >= sent.
  void add(Micros sent, Micros theirs, Micros received);
  std::size_t samples() const { return samples_.size(); }
  /// Their clock minus ours, us, from the last kKept samples; 0 before the first.
  Micros offset() const;
  /// Whether no one difference of the clocks fits all of the same samples: another clock that keeps time, and is
  /// steered like ours, never looks like that. It has been lied about.
  bool is_contradictory() const;
  /// The least round trip of the same samples, us; 0 before the first.
  Micros round_trip() const;

  static constexpr std::size_t kKept = 64;
  static constexpr Micros kTolerance = 100'000;  ///< far more than two clocks drift apart meanwhile

 private:
  struct Sample {
    Micros forth;  ///< theirs - sent: the difference plus the way there
    Micros back;   ///< theirs - received: the difference minus the way back
  };
  /// The limits within which the samples put the difference of the clocks.
  Sample limits() const;
  std::deque<Sample> samples_;
};

/// The session's time as a function of a local monotonic clock. It runs at the local rate plus a correction, which is
/// so slow that time never jumps, but for skip(), and never goes back.
class SessionClock {
 public:
  /// Session time is local + offset from now on. Steps the clock: only before play begins.
  void set(Micros offset);
  /// Corrects our lead over the clock to follow, `lead` us as far as is known at `local`: by kGain of it a second, at
  /// most by kMaxSlew.
  void steer(Micros local, Micros lead);
  /// Sets the clock ahead by so many us, at once.
  void skip(Micros local, Micros by);
  /// Session time, us. It never decreases if `local` does not.
  Micros now(Micros local) const;
  /// The local time at which now() reaches `session`, to a microsecond or so; never too early.
  Micros local_at(Micros session) const;
  /// Rate of the present correction, as a fraction.
  double slew() const { return slew_; }

  static constexpr double kMaxSlew = 0.005;
  /// 1/s. The lead is a minimum over several seconds, which shows a correction late: a higher gain would oscillate.
  static constexpr double kGain = 0.05;

 private:
  Micros base_local_ = 0;
  Micros base_session_ = 0;
  double slew_ = 0;
};

}  // namespace padr::node
