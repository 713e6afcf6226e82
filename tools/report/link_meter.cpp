#include "tools/report/link_meter.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace padr::report {
namespace {

double percentile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

}  // namespace

void LinkMeter::sent(std::uint32_t seq, Tick tick) {
  departures_.push_back({seq, tick});
}

void LinkMeter::received(std::uint32_t seq, Tick mark, Micros at) {
  arrivals_.push_back({seq, static_cast<double>(at - tick_start(mark)) / 1000.0});
}

Link LinkMeter::result(PeerId from, PeerId to, Tick receiver_end) const {
  Link l;
  l.from = from;
  l.to = to;
  l.sent = departures_.size();
  std::unordered_set<std::uint32_t> seen;
  std::uint32_t newest = 0;
  std::vector<double> delays;
  double steps_ms = 0;
  double sum_ms = 0;
  for (const Arrival& a : arrivals_) {
    if (!seen.insert(a.seq).second) {
      ++l.duplicates;
      continue;
    }
    if (a.seq < newest) ++l.reordered;
    newest = std::max(newest, a.seq);
    if (!delays.empty()) steps_ms += std::abs(a.delay_ms - delays.back());
    delays.push_back(a.delay_ms);
    sum_ms += a.delay_ms;
  }
  l.received = delays.size();
  for (const Departure& d : departures_) {
    if (d.tick > receiver_end - kTicksPerSecond) continue;
    ++l.judged;
    if (!seen.contains(d.seq)) ++l.lost;
  }
  if (delays.empty()) return l;
  l.delay_mean_ms = sum_ms / static_cast<double>(delays.size());
  if (delays.size() > 1) l.jitter_ms = steps_ms / static_cast<double>(delays.size() - 1);
  std::sort(delays.begin(), delays.end());
  l.delay_p50_ms = percentile(delays, 0.5);
  l.delay_p95_ms = percentile(delays, 0.95);
  return l;
}

}  // namespace padr::report
