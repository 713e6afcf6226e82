#include "tools/capture/distribution.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace padr::capture {
namespace {

/// Of the value that has this share of all at or below it, counted from 1.
std::uint64_t rank_of(std::uint64_t count, double share) {
  return std::max<std::uint64_t>(static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count))), 1);
}

}  // namespace

NumberWindow::Seen NumberWindow::add(std::uint32_t n) {
  if (distinct_ == 0) {
    lowest_ = highest_ = n;
    set(n);
    distinct_ = 1;
    return Seen::kNew;
  }
  if (n > highest_) {
    if (n - highest_ >= kSize) {
      bits_.fill(0);
    } else {
      for (std::uint32_t i = highest_ + 1; i < n; ++i) clear(i);
    }
    highest_ = n;
    set(n);
    ++distinct_;
    return Seen::kNew;
  }
  if (highest_ - n >= kSize || bit(n)) return Seen::kAgain;
  set(n);
  ++distinct_;
  lowest_ = std::min(lowest_, n);
  return Seen::kNewLate;
}

void ToldLoss::add(std::uint32_t lowest, std::uint32_t highest, std::uint32_t percent) {
  if (highest <= kUnderWay) return;
  const std::uint32_t judged = highest - kUnderWay;
  if (!begun_) counted_to_ = last_ = std::min(lowest - std::min(lowest, 1U), judged);
  begun_ = true;
  last_ = std::max(last_, judged);
  last_percent_ = percent;
  if (last_ - counted_to_ < kWindow) return;
  const std::uint32_t more = last_ - counted_to_;
  of_ += more;
  lost_ += more * static_cast<double>(percent) / 100;
  counted_to_ = last_;
}

double ToldLoss::percent() const {
  if (of() == 0) return 0;
  const double open = (last_ - counted_to_) * static_cast<double>(last_percent_) / 100;
  return 100 * (lost_ + open) / static_cast<double>(of());
}

std::size_t Gaps::bin(std::uint64_t us) {
  const unsigned width = static_cast<unsigned>(std::bit_width(us));
  if (width <= kFine + 1) return us;
  const unsigned shift = width - kFine - 1;
  return std::min<std::size_t>((std::size_t{shift} << kFine) + (us >> shift), kBins - 1);
}

double Gaps::middle(std::size_t bin) {
  if (bin < (2U << kFine)) return static_cast<double>(bin);
  const std::size_t shift = (bin >> kFine) - 1;
  const std::size_t top = bin - (shift << kFine);
  return (static_cast<double>(top) + 0.5) * static_cast<double>(std::uint64_t{1} << shift);
}

void Gaps::add(std::int64_t us) {
  const std::int64_t v = std::max<std::int64_t>(us, 0);
  ++bins_[bin(static_cast<std::uint64_t>(v))];
  ++count_;
  sum_ += static_cast<double>(v);
}

double Gaps::percentile_us(double share) const {
  const std::uint64_t rank = rank_of(count_, share);
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i)
    if ((below += bins_[i]) >= rank) return middle(i);
  return 0;
}

void Delays::add(std::int64_t us) {
  if (count_ == 0) {
    least_ = us;
  } else {
    differences_ += std::abs(static_cast<double>(us - last_));
  }
  ++bins_[us / step_ - (us % step_ < 0 ? 1 : 0)];
  if (bins_.size() > kMostBins) {
    step_ *= 2;
    std::map<std::int64_t, std::uint64_t> coarser;
    for (const auto& [bin, n] : bins_) coarser[bin >> 1] += n;
    bins_ = std::move(coarser);
  }
  ++count_;
  sum_ += static_cast<double>(us);
  least_ = std::min(least_, us);
  last_ = us;
}

double Delays::percentile_us(double share) const {
  const std::uint64_t rank = rank_of(count_, share);
  std::uint64_t below = 0;
  for (const auto& [bin, n] : bins_)
    if ((below += n) >= rank) return (static_cast<double>(bin) + 0.5) * static_cast<double>(step_);
  return 0;
}

}  // namespace padr::capture
