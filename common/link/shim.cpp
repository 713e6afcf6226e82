#include "common/link/shim.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

// netem is a queue driven by two events: a packet arrives, and its watchdog fires at the time it was last set to. After
// either it sends what it can and sets the watchdog anew. Slots make the outcome depend on when that happens (a slot is
// drawn when the queue is looked at), so the same two events are replayed here at exactly the times they would have
// had: run_until(now) fires every watchdog up to now before anything else happens at now. A caller that polls more
// often therefore changes nothing.
//
// A trace holds packets back after their delay, as slots do. The packet that is due first gets the first opportunity
// that is not before it is due. Until then jitter may bring one that is due earlier still, so nothing is taken from an
// opportunity before its time.

namespace padr::link {

namespace {

constexpr Nanos kBeforeTime = std::numeric_limits<Nanos>::min() / 2;
constexpr Nanos kEndOfTime = std::numeric_limits<Nanos>::max() / 2;

Nanos to_nanos(Micros t) {
  assert(t >= -(Micros{1} << 52U) && t <= (Micros{1} << 52U));
  return t * kNanosPerMicro;
}

/// Rounded up: never early.
Micros to_micros(Nanos t) {
  return t / kNanosPerMicro + (t % kNanosPerMicro > 0 ? 1 : 0);
}

/// A seed in the specification, which many links may share, leaves each of them streams of its own.
std::uint64_t seed_of(const NetemSpec& spec, std::uint64_t link) {
  return spec.seed ? derive_seed(*spec.seed, link) : link;
}

bool is_perfect(NetemSpec spec) {
  spec.seed.reset();
  return spec == NetemSpec{};
}

}  // namespace

Shim::Draws::Draws(std::uint64_t seed, const NetemSpec& spec)
    : loss(derive_seed(seed, 1), spec.loss),
      duplicate(derive_seed(seed, 2), spec.duplicate.correlation),
      corrupt(derive_seed(seed, 3), spec.corrupt.correlation),
      reorder(derive_seed(seed, 4), spec.reorder.correlation),
      delay(derive_seed(seed, 5), spec.delay.correlation),
      bit(derive_seed(seed, 6)),
      slot(derive_seed(seed, 7)),
      trace(derive_seed(seed, 8)) {}

void Shim::Draws::set_spec(const NetemSpec& spec) {
  loss.set_model(spec.loss);
  duplicate.set_correlation(spec.duplicate.correlation);
  corrupt.set_correlation(spec.corrupt.correlation);
  reorder.set_correlation(spec.reorder.correlation);
  delay.set_correlation(spec.delay.correlation);
}

Shim::Shim(const NetemSpec& spec, std::uint64_t seed)
    : spec_(spec),
      perfect_(is_perfect(spec)),
      seed_(seed),
      draws_(seed_of(spec, seed), spec),
      now_(kBeforeTime),
      slot_next_(kBeforeTime) {
  begin_trace();
}

void Shim::accept(Micros now, std::span<const std::byte> datagram) {
  run_until(to_nanos(now));
  ++stats_.accepted;
  stats_.accepted_bytes += datagram.size();
  enter(Bytes(datagram.begin(), datagram.end()), true);
  dequeue();
}

bool Shim::pass(Micros now, std::span<const std::byte> datagram) {
  if (!perfect_ || in_flight() > 0) return false;
  run_until(to_nanos(now));
  ++stats_.accepted;
  ++stats_.released;
  stats_.accepted_bytes += datagram.size();
  stats_.released_bytes += datagram.size();
  return true;
}

std::optional<std::vector<std::byte>> Shim::release(Micros now) {
  run_until(to_nanos(now));
  if (left_.empty()) return std::nullopt;
  Bytes bytes = std::move(left_.front().bytes);
  left_.pop_front();
  ++stats_.released;
  stats_.released_bytes += bytes.size();
  return bytes;
}

std::optional<Micros> Shim::next_due() const {
  if (!left_.empty()) return to_micros(left_.front().at);
  if (queue_.empty()) return std::nullopt;
  return to_micros(wake_time());
}

void Shim::set_spec(Micros now, const NetemSpec& spec) {
  run_until(to_nanos(now));
  spec_ = spec;
  perfect_ = is_perfect(spec);
  if (spec.seed) {
    draws_ = Draws(seed_of(spec, seed_), spec);
  } else {
    draws_.set_spec(spec);
  }
  since_reorder_ = 0;
  slot_next_ = now_;
  slot_packets_ = spec.slot.packets;
  slot_bytes_ = spec.slot.bytes;
  begin_trace();
  dequeue();
}

/// One packet from the top of the queueing discipline to its place in the queue. A packet that is both duplicated and
/// lost is sent exactly once, and counts as neither.
void Shim::enter(Bytes bytes, bool may_duplicate) {
  int copies = 1;
  if (may_duplicate && draws_.duplicate.chance(spec_.duplicate.chance)) ++copies;
  if (draws_.loss.next()) --copies;
  if (copies == 0) {
    ++stats_.lost;
    return;
  }
  if (copies == 2) {
    ++stats_.duplicated;
    enter(bytes, false);  // the clone is ahead of the packet itself
  }
  if (draws_.corrupt.chance(spec_.corrupt.chance)) corrupt(bytes);
  if (queue_.size() >= spec_.limit) {
    ++stats_.overlimit;
    return;
  }
  schedule(std::move(bytes));
}

void Shim::corrupt(Bytes& bytes) {
  if (bytes.empty()) return;
  ++stats_.corrupted;
  const auto bit = draws_.bit.below(static_cast<std::uint32_t>(bytes.size() * 8));
  bytes[bit / 8] ^= std::byte{1} << (bit % 8);
}

/// `reorder` first: after gap - 1 delayed packets each may be sent at once. All others are delayed; with a rate, a
/// packet starts when the last one in the queue has been sent, and what it waits for that counts as delay. With a trace
/// a packet that is sent at once is not delayed, but waits for an opportunity.
void Shim::schedule(Bytes bytes) {
  const bool may_go_at_once = spec_.gap != 0 && since_reorder_ >= spec_.gap - 1;
  if (may_go_at_once && draws_.reorder.chance(spec_.reorder.chance)) {
    since_reorder_ = 0;
    ++stats_.reordered;
    if (traced()) {
      queue_.emplace(now_, std::move(bytes));
    } else {
      leave(std::move(bytes));  // past the queue and past slots
    }
    return;
  }
  ++since_reorder_;

  const DelaySpec& d = spec_.delay;
  Nanos delay = d.mean;
  if (d.jitter != 0) delay = distributed(d.mean, d.jitter, distribution_table(d.distribution), draws_.delay.next());
  Nanos from = now_;
  if (spec_.rate.bits_per_second != 0) {
    if (!queue_.empty()) {
      from = queue_.rbegin()->first;
      delay = std::max<Nanos>(0, delay - (from - now_));
    }
    delay += transmission_time(bytes.size());
  }
  if (traced()) delay = std::max<Nanos>(0, delay);  // the head may be on its way already
  queue_.emplace(std::min(from + delay, kEndOfTime), std::move(bytes));
}

Nanos Shim::transmission_time(std::size_t payload) const {
  const RateSpec& r = spec_.rate;
  std::int64_t length = static_cast<std::int64_t>(payload + kHeaderBytes) + r.overhead;
  if (r.cell != 0 && length > 0) {
    const std::int64_t cells = (length + r.cell - 1) / r.cell;
    length = cells * (std::int64_t{r.cell} + r.cell_overhead);
  }
  if (length <= 0) return 0;
  // Double: bits * 10^9 does not fit 64 bits for long packets of many cells.
  const double nanos = static_cast<double>(length) * 8e9 / static_cast<double>(r.bits_per_second);
  return static_cast<Nanos>(std::min(nanos, 1e18));  // 30 years; keeps sums within kEndOfTime
}

void Shim::run_until(Nanos now) {
  while (!queue_.empty() && wake_time() <= now) {
    now_ = std::max(now_, wake_time());
    dequeue();
  }
  now_ = std::max(now_, now);
}

/// When the watchdog is set to fire.
Nanos Shim::wake_time() const {
  const Nanos head = queue_.begin()->first;
  if (traced()) return time_of(opportunity_for(head));
  return spec_.slot.on ? std::max(head, slot_next_) : head;
}

/// Sends what can be sent at now_. A slot that began before the head of the queue was due has passed unused.
void Shim::dequeue() {
  while (!queue_.empty()) {
    const auto head = queue_.begin();
    if (spec_.slot.on && slot_next_ < head->first) open_slot();
    if (wake_time() > now_) return;
    if (traced() && !carry(head->first, head->second.size())) continue;
    Bytes bytes = std::move(head->second);
    queue_.erase(head);
    if (spec_.slot.on) count_in_slot(bytes.size());
    leave(std::move(bytes));
  }
}

void Shim::leave(Bytes bytes) {
  left_.push_back({now_, std::move(bytes)});
}

void Shim::count_in_slot(std::size_t payload) {
  --slot_packets_;
  slot_bytes_ -= static_cast<std::int64_t>(payload + kHeaderBytes);
  const bool full = (spec_.slot.packets != 0 && slot_packets_ <= 0) || (spec_.slot.bytes != 0 && slot_bytes_ <= 0);
  if (full) open_slot();
}

/// Draws when the next slot begins, counted from now.
void Shim::open_slot() {
  const SlotSpec& s = spec_.slot;
  const std::uint32_t draw = draws_.slot.next_u32();
  Nanos wait = 0;
  if (s.distribution) {
    wait = distributed(s.delay, s.jitter, distribution_table(*s.distribution), draw);
  } else {
    wait = s.min + static_cast<Nanos>(draw * static_cast<double>(s.max - s.min) * 0x1p-32);
  }
  slot_next_ = now_ + wait;
  slot_packets_ = s.packets;
  slot_bytes_ = s.bytes;
}

/// From now_ on, with an opportunity that is now. Nothing of the head is on its way.
void Shim::begin_trace() {
  carried_ = 0;
  if (!traced()) return;
  const std::uint32_t last = spec_.trace.opportunities->back();
  const Nanos start = spec_.trace.start ? *spec_.trace.start : draws_.trace.below(last) * kNanosPerMilli;
  trace_began_ = -(start % (last * kNanosPerMilli));
  next_ = {trace_began_, 0};
  next_ = opportunity_for(now_);
  room_ = kOpportunityBytes;
}

/// The first one with room left that is not before `due`.
Shim::Opportunity Shim::opportunity_for(Nanos due) const {
  const auto& times = *spec_.trace.opportunities;
  const Nanos period = times.back() * kNanosPerMilli;
  // An end of one repetition and the begin of the next are one time; the end comes first.
  const Nanos since = due - trace_began_;
  const Nanos repetition = since > 0 ? (since - 1) / period * period : 0;
  const auto line = std::partition_point(
      times.begin(), times.end(), [left = since - repetition](std::uint32_t ms) { return ms * kNanosPerMilli < left; });
  return std::max(next_, {trace_began_ + repetition, static_cast<std::size_t>(line - times.begin())});
}

Nanos Shim::time_of(const Opportunity& o) const {
  return o.repetition + (*spec_.trace.opportunities)[o.line] * kNanosPerMilli;
}

/// Puts of the head, due then, what has room into the opportunity that is now; true if that is the rest of it.
bool Shim::carry(Nanos due, std::size_t payload) {
  const Opportunity now = opportunity_for(due);
  if (now != next_) room_ = kOpportunityBytes;
  next_ = now;
  const auto rest = static_cast<std::int64_t>(payload + kHeaderBytes) - carried_;
  const std::int64_t taken = std::min(rest, room_);
  room_ -= taken;
  carried_ = taken < rest ? carried_ + taken : 0;
  if (room_ == 0) {
    room_ = kOpportunityBytes;
    if (++next_.line == spec_.trace.opportunities->size()) {
      next_ = {next_.repetition + spec_.trace.opportunities->back() * kNanosPerMilli, 0};
    }
  }
  return taken == rest;
}

}  // namespace padr::link
