#include "common/delivery/link_rate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace padr::sync {
namespace {

// Another rate is taken if what it leaves unexplained of the latest receipts' lateness, ticks, is this part or less of
// what the present one leaves, and less by at least so much.
constexpr float kBetter = 0.25F;
constexpr float kClearly = 20;
// And by so many times what the best rate has left unexplained of late, jitter, on average over about so many receipts.
constexpr float kJitter = 3;
constexpr int kOfLate = 16;
// Where the present rate leaves less, no other one is looked for.
constexpr float kLittle = 5;
// The estimate grows by a factor in this range while something is held back.
constexpr double kGrowth = 1.25;
constexpr double kMostGrowth = 2;
constexpr Tick kGrowEvery = 6;  // at least
// After so long without a change it grows on trial, and after half of that the next time, until a queue contradicts it.
constexpr Tick kTrial = 10 * kTicksPerSecond;
// By no less than this, ticks, do all datagrams come later if the link has become longer.
constexpr float kLonger = 3;
// A queue is taken to have begun no more than this many datagrams ago.
constexpr std::size_t kQueued = 64;
std::size_t first_that_may_have_begun_it(std::size_t last) {
  return last < kQueued ? 0 : last - kQueued;
}
// Where datagrams wait longer than this, ticks, what gets lost is taken to have found no room in the queue.
constexpr float kFull = 24;
// What came through is measured over no less than this.
constexpr Tick kMeasured = 6;
// What came so many ticks before it was sent, and before all of late, came to a peer whose ticks were far behind its
// clock. It is believed only of so many in a row: then a clock was set.
constexpr Tick kTooQuick = 6;
constexpr int kTooQuickInARow = 16;
// Times are whole ticks at both ends.
constexpr float kResolution = 0.5F;
// What is sent waits for an empty queue no longer than this, s.
constexpr double kLongestWait = 4;

// A mark in each of the longest intervals: no link is taken to carry less, bytes/s.
constexpr double kLeast = 60;
// Of what a link carries, so much is meant to be used: the rest is for what is sent again, and keeps the queue short.
constexpr double kUsed = 0.9;

double seconds(double ticks) {
  return ticks / kTicksPerSecond;
}

}  // namespace

double LinkRate::meant() const {
  return std::min(kUsed * rate_, most_);
}

double LinkRate::ahead(Tick now) const {
  return std::clamp(ahead_ - seconds(std::max(0, now - drained_)), 0.0, kMostAhead);
}

Tick LinkRate::mark_interval(std::size_t bytes) const {
  if (window_is_full()) return kLongestMarkInterval;
  return static_cast<Tick>(
      std::min<double>(kLongestMarkInterval, std::ceil(static_cast<double>(bytes) * 8 * kTicksPerSecond / rate())));
}

void LinkRate::drain(Tick now) {
  const double passed = seconds(std::max(0, now - drained_));
  ahead_ = std::max(0.0, ahead_ - passed);
  queued_ = std::max(0.0, queued_ - passed * rate_);
  drained_ = std::max(drained_, now);
}

bool LinkRate::may_tell(Tick now) {
  const bool within_bound = most_ > kUsed * rate_ || ahead(now) < kMostAhead;
  return may_send(now) && within_bound;
}

bool LinkRate::may_send(Tick now) {
  drain(now);
  const bool may = queued_ <= 0 && !window_is_full();
  if (!may) {
    held_back_ = true;
    held_at_ = now;
  }
  return may;
}

void LinkRate::sent(std::size_t bytes, Tick now, bool late) {
  drain(now);
  queued_ += static_cast<double>(bytes);
  unacknowledged_ += static_cast<double>(bytes);
  ahead_ = std::min(2 * kMostAhead, ahead_ + static_cast<double>(bytes) / meant());
  sent_.push_back({now, bytes, late});
  if (sent_.size() <= kRemembered) return;
  sent_.pop_front();
  ++forgotten_;
}

void LinkRate::note_transit(const Quickest& q, Tick now) {
  if (now - span_ > kSpan) {
    was_quickest_ = span_ == kNever ? q : now_quickest_;
    now_quickest_ = q;
    span_ = now;
  }
  if (q.transit < now_quickest_.transit) now_quickest_ = q;
}

const LinkRate::Quickest& LinkRate::quickest() const {
  return was_quickest_.transit < now_quickest_.transit ? was_quickest_ : now_quickest_;
}

float LinkRate::lateness(const Receipt& r) const {
  return static_cast<float>(r.transit - quickest().transit);
}

// The queue began with some datagram before: the rate is what the link carried from then on until this one had left it.
// Of all datagrams that may have begun it, the one that did makes the rate highest.
double LinkRate::explains(const Receipt& r) const {
  const float late = std::max(kResolution, lateness(r));
  double bytes = -static_cast<double>(quickest().bytes);
  double rate = 0;
  const std::size_t last = r.number - forgotten_;
  for (std::size_t i = last + 1; i-- > first_that_may_have_begun_it(last);) {
    bytes += passed_ * static_cast<double>(sent_[i].bytes);
    rate = std::max(rate, bytes / seconds(static_cast<double>(sent_[last].at - sent_[i].at) + late));
  }
  return rate;
}

// By how many ticks that datagram is later than the quickest, at a rate.
float LinkRate::predicted(const Receipt& r, double rate) const {
  double bytes = -static_cast<double>(quickest().bytes);
  double late = 0;
  const double ticks_per_byte = kTicksPerSecond / rate;
  const std::size_t last = r.number - forgotten_;
  for (std::size_t i = last + 1; i-- > first_that_may_have_begun_it(last);) {
    bytes += passed_ * static_cast<double>(sent_[i].bytes);
    const double by_it = bytes * ticks_per_byte - static_cast<double>(sent_[last].at - sent_[i].at);
    late = std::max(late, by_it);
  }
  return static_cast<float>(late);
}

// Bytes per second that have come through between the oldest and the newest of the receipts, 0 if they are too close.
double LinkRate::came_through() const {
  const Receipt& from = receipts_.front();
  const Receipt& to = receipts_.back();
  const Tick ticks = to.transit + sent_[to.number - forgotten_].at - from.transit - sent_[from.number - forgotten_].at;
  if (ticks < kMeasured) return 0;
  double bytes = 0;
  for (std::size_t i = from.number + 1; i <= to.number; ++i) bytes += static_cast<double>(sent_[i - forgotten_].bytes);
  return passed_ * bytes / seconds(static_cast<double>(ticks));
}

float LinkRate::unexplained(double rate) const {
  float sum = 0;
  for (std::size_t i = 0; i < receipts_.size(); ++i)
    sum += std::abs(lateness(receipts_[i]) - predicted(receipts_[i], rate));
  return sum;
}

// By how much all of the latest receipts are later than the estimate's queues explain: the link has become longer.
float LinkRate::longer() const {
  if (receipts_.size() < kReceipts) return 0;
  float least_late = std::numeric_limits<float>::max();
  float least_expected = least_late;
  for (std::size_t i = 0; i < receipts_.size(); ++i) {
    least_late = std::min(least_late, lateness(receipts_[i]));
    least_expected = std::min(least_expected, predicted(receipts_[i], rate_));
  }
  const float longer = least_late - least_expected;
  return longer < kLonger ? 0 : longer;
}

// By what factor the link carries more than the estimate, as the latest receipts show: 1, or a growth. Only those that
// come earlier than the estimate's queue explains show it: a busy machine and jitter make others later. `longer`: ticks
// that all take more by now.
double LinkRate::growth(float longer) const {
  double early = 0;
  double expected = 0;
  for (std::size_t i = 0; i < receipts_.size(); ++i) {
    const float late = predicted(receipts_[i], rate_);
    expected += late;
    early += std::max(0.0F, late + longer - lateness(receipts_[i]));
  }
  if (early < kBetter * expected) return 1;
  return early > 0 ? std::clamp(expected / std::max(expected - early, 1e-3), kGrowth, kMostGrowth) : kGrowth;
}

void LinkRate::set_rate(double rate, Tick now) {
  drain(now);
  rate_ = std::clamp(rate, kLeast, kMost);
  queued_ = 0;
  double bytes = 0;
  for (std::size_t i = sent_.size(); i-- > 0;) {
    bytes += static_cast<double>(sent_[i].bytes);
    queued_ = std::max(queued_, bytes - seconds(static_cast<double>(now - sent_[i].at)) * rate_);
  }
  queued_ = std::min(queued_, kLongestWait * rate_);
}

void LinkRate::acknowledged(std::size_t later) {
  if (!window_) return;
  const double before = std::exchange(unacknowledged_, 0);
  for (std::size_t i = 0; i < later; ++i) unacknowledged_ += static_cast<double>(sent_[sent_.size() - 1 - i].bytes);
  *window_ += std::max(0.0, before - unacknowledged_);
  if (is_limited() || *window_ > kLastWindow) window_.reset();
}

void LinkRate::arrived(std::size_t later, Tick received, Tick now, float round_trip, double loss) {
  const std::size_t place = sent_.size() - 1 - later;
  const Tick transit = received - sent_[place].at;
  const bool too_quick = span_ != kNever && transit < std::min(0, quickest().transit) - kTooQuick;
  if (sent_[place].late || (too_quick && ++too_quick_ < kTooQuickInARow)) return;
  too_quick_ = 0;
  receipts_.push_back({forgotten_ + place, transit});
  while (receipts_.size() > kReceipts || receipts_.front().number < forgotten_) receipts_.pop_front();
  note_transit({receipts_.back().transit, sent_[place].bytes}, now);
  queue_ = lateness(receipts_.back());
  passed_ = queue_ > kFull ? 1 - loss : 1;
  const float left = unexplained(rate_);
  double best = rate_;
  float least = left;
  for (const Receipt& r : {receipts_.back(), receipts_.front()}) {
    if (left <= kLittle) break;
    const double candidate = std::max(explains(r), came_through());
    const float leaves = unexplained(candidate);
    if (leaves >= least) continue;
    least = leaves;
    best = candidate;
  }
  // By chance jitter has as many datagrams in a row come as late as the queue of a far narrower link would. One tick of
  // each is its rounding.
  const float clearly = kClearly + (best < rate_ / 2 ? kJitter * std::max(0.0F, jitter_ - kReceipts) : 0);
  judged_ = std::min(judged_ + 1, kOfLate);
  jitter_ += (least * static_cast<float>(kReceipts) / static_cast<float>(receipts_.size()) - jitter_) /
             static_cast<float>(judged_);
  if (least < kBetter * left && least + clearly < left) {
    set_rate(best, now);
    changed_ = now;
    until_trial_ = kTrial;
    return;
  }
  if (held_back_ && now - changed_ > std::max(static_cast<Tick>(round_trip), kGrowEvery)) {
    const float by = longer();
    double factor = growth(by);
    if (factor == 1 && now - changed_ > until_trial_ && left >= kBetter * unexplained(kMost)) {
      factor = kGrowth;
      until_trial_ /= 2;
    }
    if (factor == 1) return;
    // The quickest datagram takes so much more, too, or what is no queue is soon explained by a low rate again.
    now_quickest_ = was_quickest_ = {quickest().transit + static_cast<Tick>(by), quickest().bytes};
    changed_ = now;
    held_back_ = false;
    set_rate(rate_ * factor, now);
  }
}

}  // namespace padr::sync
