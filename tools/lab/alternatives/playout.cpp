#include "tools/lab/alternatives/playout.h"

#include <algorithm>

namespace padr::lab::alternatives {
namespace {

constexpr Tick kMemory = 3 * kTicksPerSecond;
constexpr std::size_t kCounted = 100;
constexpr double kSomeLoss = 0.01;
constexpr double kMuchLoss = 0.2;

}  // namespace

void Playout::count(std::uint8_t number) {
  const auto ahead = static_cast<std::int8_t>(static_cast<std::uint8_t>(number - number_));
  if (!heard_ || ahead > 0) {
    for (int i = 1; heard_ && i < ahead; ++i) arrived_.push_back(false);
    arrived_.push_back(true);
    number_ = number;
    heard_ = true;
  } else if (ahead < 0 && static_cast<std::size_t>(-ahead) < arrived_.size()) {
    arrived_[arrived_.size() - 1 - static_cast<std::size_t>(-ahead)] = true;
  }
  while (arrived_.size() > kCounted) arrived_.pop_front();
}

void Playout::add(const Content& c, std::uint8_t number, Tick now) {
  const bool next = heard_ && static_cast<std::uint8_t>(number_ + 1) == number;
  count(number);
  ages_.push_back({now, now - c.tick});
  if (!contents_.empty() && next && c.tick - contents_.back().tick > interval_) {
    // The sender paused because nothing changed: it was still like this just before.
    Content still = contents_.back();
    still.tick = c.tick - interval_;
    contents_.push_back(std::move(still));
  }
  const auto place =
      std::lower_bound(contents_.begin(), contents_.end(), c.tick, [](const Content& o, Tick t) { return o.tick < t; });
  if (place != contents_.end() && place->tick == c.tick) {
    *place = c;
  } else {
    contents_.insert(place, c);
  }
}

Tick Playout::wanted() const {
  Tick worst = 0;
  for (const Age& a : ages_) worst = std::max(worst, a.age);
  const auto lost = static_cast<double>(std::count(arrived_.begin(), arrived_.end(), false));
  const double share = arrived_.empty() ? 0 : lost / static_cast<double>(arrived_.size());
  const Tick spare = share >= kMuchLoss ? 2 : (share >= kSomeLoss ? 1 : 0);
  return worst + interval_ - 1 + spare * interval_;
}

void Playout::advance(Tick now) {
  while (!ages_.empty() && ages_.front().came < now - kMemory) ages_.pop_front();
  if (!ages_.empty()) {
    const Tick want = wanted();
    if (want > delay_) {
      delay_ = want;
    } else if (want < delay_ && now - shrunk_ >= kTicksPerSecond) {
      --delay_;
      shrunk_ = now;
    }
  }
  // One before the moment is kept for the curve.
  while (contents_.size() > 2 && contents_[2].tick <= now - delay_) contents_.pop_front();
}

std::optional<Playout::Moment> Playout::moment(Tick now) const {
  Moment m;
  m.at = now - delay_;
  for (std::size_t i = 0; i < contents_.size() && contents_[i].tick <= m.at; ++i) {
    m.before = i > 0 ? &contents_[i - 1] : nullptr;
    m.a = m.b = &contents_[i];
    m.after = nullptr;
    if (i + 1 < contents_.size()) m.b = &contents_[i + 1];
    if (i + 2 < contents_.size()) m.after = &contents_[i + 2];
  }
  if (m.a == nullptr) return std::nullopt;
  return m;
}

}  // namespace padr::lab::alternatives
