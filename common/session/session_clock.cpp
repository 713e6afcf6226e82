#include "common/session/session_clock.h"

#include <algorithm>
#include <cmath>

namespace padr::node {

void OffsetEstimator::add(Micros sent, Micros theirs, Micros received) {
  samples_.push_back({theirs - sent, theirs - received});
  if (samples_.size() > kKept) samples_.pop_front();
}

OffsetEstimator::Sample OffsetEstimator::limits() const {
  Sample limits = samples_.front();
  for (const Sample& s : samples_) limits = {std::min(limits.forth, s.forth), std::max(limits.back, s.back)};
  return limits;
}

Micros OffsetEstimator::offset() const {
  if (samples_.empty()) return 0;
  const Sample l = limits();
  return l.back + (l.forth - l.back) / 2;
}

bool OffsetEstimator::is_contradictory() const {
  if (samples_.empty()) return false;
  const Sample l = limits();
  return l.back > l.forth + kTolerance;
}

Micros OffsetEstimator::round_trip() const {
  Micros least = samples_.empty() ? 0 : samples_.front().forth - samples_.front().back;
  for (const Sample& s : samples_) least = std::min(least, s.forth - s.back);
  return least;
}

void SessionClock::set(Micros offset) {
  base_local_ = 0;
  base_session_ = offset;
  slew_ = 0;
}

void SessionClock::steer(Micros local, Micros lead) {
  base_session_ = now(local);
  base_local_ = std::max(local, base_local_);
  slew_ = std::clamp(-static_cast<double>(lead) / static_cast<double>(kMicrosPerSecond) * kGain, -kMaxSlew, kMaxSlew);
}

void SessionClock::skip(Micros local, Micros by) {
  base_session_ = now(local) + by;
  base_local_ = std::max(local, base_local_);
}

Micros SessionClock::now(Micros local) const {
  const Micros passed = slew_ == 0 ? local - base_local_ : std::max<Micros>(0, local - base_local_);
  return base_session_ + passed + static_cast<Micros>(std::floor(static_cast<double>(passed) * slew_));
}

Micros SessionClock::local_at(Micros session) const {
  const auto ahead = static_cast<double>(session - base_session_);
  Micros local = base_local_ + static_cast<Micros>(std::ceil(ahead / (1 + slew_)));
  while (now(local) < session) ++local;
  return local;
}

}  // namespace padr::node
