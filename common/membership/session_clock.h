#pragma once

#include <cstddef>
#include <deque>

#include "common/model/ids.h"

namespace padr::node {

/// How far another clock is ahead of ours, from asking it the time again and again.
///
/// A question bounds the difference from both sides: the answer was given after we asked and before we heard it. The
/// estimate is the middle of the tightest bounds, each way's least delay by itself, so one lucky datagram each way is
/// enough, whatever queues and jitter did to the others. What remains is half the difference of the least delays.
class OffsetEstimator {
 public:
  /// All in microseconds; `sent` and `received` by our clock, `theirs` by the other. received >= sent.
  void add(Micros sent, Micros theirs, Micros received);
  std::size_t samples() const { return samples_.size(); }
  /// Theirs minus ours, of the last kKept samples; 0 before the first.
  Micros offset() const;
  /// The least of the same samples; 0 before the first.
  Micros round_trip() const;

  static constexpr std::size_t kKept = 64;

 private:
  struct Sample {
    Micros forth;  ///< theirs - sent: the difference plus the way there
    Micros back;   ///< theirs - received: the difference minus the way back
  };
  std::deque<Sample> samples_;
};

/// The session's time as a function of a local monotonic clock: runs at the local rate, but for a correction so slow
/// that time never jumps and never goes back.
class SessionClock {
 public:
  /// Session time is local + offset from here on. Steps the clock: only for use before the session begins.
  void set(Micros offset);
  /// We are `lead` microseconds ahead of the clock to follow, as far as is known at `local`. Corrects by kGain of it
  /// a second, at most by kMaxSlew.
  void steer(Micros local, Micros lead);
  /// Session time, us. Does not decrease as `local` does not.
  Micros now(Micros local) const;
  /// The local time at which now() reaches `session`, to a microsecond or so; never too early.
  Micros local_at(Micros session) const;
  /// Rate of the correction at work, in parts of 1.
  double slew() const { return slew_; }

  static constexpr double kMaxSlew = 0.005;
  /// 1/s. The lead is the least of several seconds, half of it only seen after that: faster would swing.
  static constexpr double kGain = 0.05;

 private:
  Micros base_local_ = 0;
  Micros base_session_ = 0;
  double slew_ = 0;
};

}  // namespace padr::node
