#include "common/replica/one_way_delays.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace padr::node {

void Arrivals::sample(Tick sent, Micros arrived) {
  const Sample s{arrived, arrived - tick_start(sent)};
  if (ring_.empty()) ring_.reserve(kSamples);
  if (ring_.size() < kSamples) {
    ring_.push_back(s);
  } else {
    ring_[next_] = s;
  }
  next_ = (next_ + 1) % kSamples;
}

Arrivals::Delays Arrivals::delays(Micros now) const {
  assert(any());
  std::array<Micros, kSamples> recent{};
  std::size_t n = 0;
  for (const Sample& s : ring_)
    if (now - s.arrived <= kSpan) recent[n++] = s.transit;
  if (n == 0) recent[n++] = ring_[(next_ + kSamples - 1) % kSamples].transit;
  // Nearest rank, as in padr-report.
  const auto at = [&recent, n](std::size_t percent) {
    const std::size_t rank = std::max<std::size_t>((n * percent + 99) / 100, 1);
    const auto nth = recent.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(recent.begin(), nth, recent.begin() + static_cast<std::ptrdiff_t>(n));
    return *nth;
  };
  return {at(50), at(95)};
}

}  // namespace padr::node
