#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/model/ids.h"

namespace padr::peer {

/// How late things began, in memory that does not grow: counted by ranges that are an eighth wide, or 1 us.
class Lateness {
 public:
  /// us after its time; what is early counts as in time. A minute and more are counted alike.
  void add(Micros late);

  std::uint64_t count() const { return count_; }
  /// us, exact.
  Micros worst() const { return worst_; }
  /// us that so large a share of all, 0 .. 1, does not exceed: an eighth too much at most, and never above the worst.
  /// 0 before anything was counted.
  Micros quantile(double share) const;

 private:
  static constexpr unsigned kStepBits = 3;
  static constexpr std::uint64_t kSteps = 1U << kStepBits;
  static constexpr unsigned kDoublings = 26;  ///< 2^26 us
  static std::size_t range_of(std::uint64_t us);
  /// The greatest number of a range, us.
  static std::uint64_t top_of(std::size_t range);

  std::array<std::uint64_t, kDoublings << kStepBits> counts_{};
  std::uint64_t count_ = 0;
  Micros worst_ = 0;
};

}  // namespace padr::peer
