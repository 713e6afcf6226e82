#include "peer/lateness.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace padr::peer {

// Below kSteps every number has a range of its own; from there on every doubling has kSteps ranges.
std::size_t Lateness::range_of(std::uint64_t us) {
  if (us < kSteps) return us;
  const auto shift = static_cast<unsigned>(std::bit_width(us)) - kStepBits - 1;
  return (shift << kStepBits) + (us >> shift);
}

std::uint64_t Lateness::top_of(std::size_t range) {
  if (range < kSteps) return range;
  const auto shift = static_cast<unsigned>(range / kSteps - 1);
  return ((range % kSteps + kSteps + 1) << shift) - 1;
}

void Lateness::add(Micros late) {
  late = std::max<Micros>(late, 0);
  worst_ = std::max(worst_, late);
  ++counts_[std::min(range_of(static_cast<std::uint64_t>(late)), counts_.size() - 1)];
  ++count_;
}

Micros Lateness::quantile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t r = 0; r < counts_.size(); ++r) {
    seen += counts_[r];
    if (seen >= std::max<std::uint64_t>(wanted, 1)) return std::min(static_cast<Micros>(top_of(r)), worst_);
  }
  return worst_;
}

}  // namespace padr::peer
