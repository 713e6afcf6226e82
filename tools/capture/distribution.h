#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace padr::capture {

/// Which of ascending numbers have been seen, in constant memory: exact for the latest 4096, which is far more than any
/// network puts out of order.
class NumberWindow {
 public:
  enum class Seen : std::uint8_t { kNew, kNewLate, kAgain };
  /// kNewLate: new, but a higher number has been seen before. What is too old to tell counts as seen.
  Seen add(std::uint32_t n);
  std::uint64_t distinct() const { return distinct_; }
  std::uint32_t highest() const { return highest_; }
  std::uint32_t lowest() const { return lowest_; }
  /// Numbers from the lowest to the highest seen: of so many `missing` is a part.
  std::uint64_t span() const { return distinct_ == 0 ? 0 : std::uint64_t{highest_} - lowest_ + 1; }
  /// Numbers between the lowest and the highest seen that have not been.
  std::uint64_t missing() const { return span() - distinct_; }

 private:
  static constexpr std::uint32_t kSize = 4096;
  bool bit(std::uint32_t n) const { return (bits_[n % kSize / 64] >> (n % 64) & 1U) != 0; }
  void set(std::uint32_t n) { bits_[n % kSize / 64] |= std::uint64_t{1} << (n % 64); }
  void clear(std::uint32_t n) { bits_[n % kSize / 64] &= ~(std::uint64_t{1} << (n % 64)); }

  std::array<std::uint64_t, kSize / 64> bits_{};
  std::uint32_t lowest_ = 0;
  std::uint32_t highest_ = 0;
  std::uint64_t distinct_ = 0;
};

/// What a receiver tells of a link's loss, over all of it. It tells a percentage of the latest 192 numbers, again and
/// again: each number counts once here.
class ToldLoss {
 public:
  /// `lowest`, `highest`: the link's numbers in the capture when it is told.
  void add(std::uint32_t lowest, std::uint32_t highest, std::uint32_t percent);
  /// How many numbers it is of; 0 if nothing was told.
  std::uint64_t of() const { return of_ + (last_ - counted_to_); }
  /// Of these, those that did not arrive. Every percentage is rounded down, so it is up to a point low.
  double percent() const;

 private:
  static constexpr std::uint32_t kUnderWay = 8;  ///< the newest are not judged
  static constexpr std::uint32_t kWindow = 192;
  std::uint32_t counted_to_ = 0;
  std::uint32_t last_ = 0;
  std::uint32_t last_percent_ = 0;
  std::uint64_t of_ = 0;
  double lost_ = 0;
  bool begun_ = false;
};

/// Times between two events: mean exactly, percentiles to 3 %.
class Gaps {
 public:
  void add(std::int64_t us);
  std::uint64_t count() const { return count_; }
  double mean_us() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  /// `share`: 0 .. 1.
  double percentile_us(double share) const;

 private:
  static constexpr unsigned kFine = 5;  ///< bits behind the leading one that count
  static constexpr std::size_t kBins = (40 - kFine) << kFine;
  static std::size_t bin(std::uint64_t us);
  static double middle(std::size_t bin);

  std::vector<std::uint32_t> bins_ = std::vector<std::uint32_t>(kBins);
  std::uint64_t count_ = 0;
  double sum_ = 0;
};

/// Values of any size, in steps of 0.25 ms, or of twice that, and so on, while they lie in too many steps. Shifting all
/// of them afterwards shifts the percentiles.
class Delays {
 public:
  void add(std::int64_t us);
  std::uint64_t count() const { return count_; }
  double mean_us() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  double percentile_us(double share) const;
  std::int64_t least_us() const { return least_; }
  /// Mean difference between successive values (RFC 3550, without its smoothing).
  double jitter_us() const { return count_ < 2 ? 0 : differences_ / static_cast<double>(count_ - 1); }

 private:
  static constexpr std::size_t kMostBins = 4096;  ///< a second in the finest steps; an outlier takes one

  std::int64_t step_ = 250;                     ///< us
  std::map<std::int64_t, std::uint64_t> bins_;  ///< by value / step, rounded down
  std::int64_t last_ = 0;
  std::int64_t least_ = 0;
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double differences_ = 0;
};

}  // namespace padr::capture
