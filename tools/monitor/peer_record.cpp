#include "tools/monitor/peer_record.h"

namespace padr::monitor {

void RateMeter::take(const Status& s) {
  if (!window_.empty() && s.tick <= window_.back().tick) {
    // Another part of the same status, or a peer that has begun anew elsewhere.
    if (s.tick == window_.back().tick) return;
    window_.clear();
  }
  window_.push_back(s);
  window_.back().links.clear();
  while (window_.size() > 2 && s.tick - window_[1].tick >= kSpan) window_.pop_front();
  const Status& then = window_.front();
  const double ticks = s.tick - then.tick;
  if (ticks <= 0) return;
  const double seconds = ticks / kTicksPerSecond;
  // Counters never go back, unless somebody lies.
  const auto grown = [](std::uint64_t now, std::uint64_t before) {
    return now > before ? static_cast<double>(now - before) : 0.0;
  };
  PeerRates r;
  for (std::size_t c = 0; c < sync::kCauses; ++c)
    r.updates_per_s[c] = grown(s.updates_by_cause[c], then.updates_by_cause[c]) / seconds;
  r.datagrams_per_s = grown(s.datagrams_sent, then.datagrams_sent) / seconds;
  r.kbit_per_s = grown(s.bytes_sent, then.bytes_sent) * 8e-3 / seconds;
  r.replayed_per_tick = grown(s.replayed_steps, then.replayed_steps) / ticks;
  rates_ = r;
}

PeerRecord::Presence PeerRecord::presence(Micros now) const {
  if (ended_at >= 0 || now - heard > kGoneAfter) return Presence::kGone;
  return now - heard > kSilentAfter ? Presence::kSilent : Presence::kHere;
}

std::optional<PeerRates> PeerRecord::current_rates(Micros now) const {
  return presence(now) == Presence::kHere && !paused() ? rates.rates() : std::nullopt;
}

std::optional<double> PeerRecord::lag_ms() const {
  if (!status || status->confirmed < 0) return std::nullopt;
  return (status->tick - status->confirmed) * 1000.0 / kTicksPerSecond;
}

}  // namespace padr::monitor
