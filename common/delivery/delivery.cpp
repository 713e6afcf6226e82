#include "common/delivery/delivery.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace padr::sync {
namespace {

// With nothing to tell, a mark goes out this often: it moves confirmed on and carries acknowledgements.
constexpr Tick kMarkInterval = 15;  // 250 ms
// Where next to nothing gets lost, acknowledgements are not urgent, and there is nothing else a mark is needed for.
constexpr Tick kCalmMarkInterval = 45;  // 750 ms
// Where more gets lost, but nothing has happened lately.
constexpr Tick kQuietMarkInterval = 36;  // 600 ms
constexpr std::uint32_t kUnquiet = 5;    // per cent lost
// So many updates from the first missing one on the other end can acknowledge one by one: that one and 32 bits.
constexpr std::uint32_t kAcknowledged = 33;
// A promised update that has not come is asked for after this long: jitter reorders, and asking costs a datagram.
constexpr Tick kGapPatience = 3;
// An update goes along with the next datagram if it is unacknowledged after this long, once.
constexpr Tick kEcho = 2;
// But only where at least this many per cent get lost: elsewhere it is waste.
constexpr std::uint32_t kLossy = 2;
// Where this many per cent get lost, the second copy does not wait for company: every fourth update that comes a round
// trip late costs more than its datagram. One that tells of bodies costs more when it is late, as they go another way
// meanwhile: its second copy goes out at once, and where less gets lost.
struct Alone {
  std::uint32_t loss;
  Tick after;
};
constexpr Alone kAlone{15, 3};
constexpr Alone kBodiesAlone{8, 1};

// Who has said nothing yet may be waiting for a first word that got lost, without which it must not speak: a newcomer
// for its admission.
constexpr Tick kUnheard = 24;
// And as long as it has said nothing, what it has been sent goes along with whatever goes out, so many times at most.
constexpr int kFirstWords = 8;

// Where an update is under way, and a round trip and a mark more than this pass without an answer, there is none to be
// expected, ticks.
constexpr Tick kAnswered = 45;

// A burst of losses takes one datagram after the other, however far apart they are; so the longer no answer comes, the
// faster a link is probed, until a peer that does not answer would be taken for silent. Who does not answer for longer
// does not matter any more to whom it is silent, or is heard by others.
struct Probing {
  Tick unanswered;  ///< for so long
  Tick interval;
};
constexpr std::array<Probing, 5> kProbing{{{60, 10}, {90, 4}, {120, 2}, {240, 6}, {360, 15}}};

/// By so many ticks a round trip is longer than usual if an end has stood still.
constexpr Tick kStandstill = kTicksPerSecond / 2;
/// So many such round trips in a row are the link's.
constexpr int kBelieved = 4;

}  // namespace

bool OutLink::arrived(std::uint32_t index) const {
  if (index < acked_) return true;
  const std::uint32_t beyond = index - acked_ - 1;
  return index > acked_ && beyond < 32 && (acked_beyond_ & (1U << beyond)) != 0;
}

OutLink::Flight& OutLink::flight(std::uint32_t index) {
  const std::size_t i = index - acked_;
  while (flights_.size() <= i) flights_.push_back({});
  return flights_[i];
}

Tick OutLink::slow_round_trip() const {
  return static_cast<Tick>(std::ceil(srtt_ + 4 * rttvar_ + rate_.queue()));
}

// Lost: something sent clearly later has arrived, or it is overdue.
bool OutLink::lost(const Flight& f, Tick now) const {
  if (heard_.seq == 0) return now - f.sent > kUnheard * std::min(f.times, 2);
  const auto slack = static_cast<Tick>(std::ceil(rttvar_));
  const Tick timeout = slow_round_trip() + interval_ + 1;
  return newest_seen_sent_ > f.sent + slack || now - f.sent > timeout * std::min(f.times, 4);
}

// Goes along with another datagram.
bool OutLink::echoes(const Flight& f, Tick now) const {
  if (now - f.sent < kEcho) return false;
  if (fresh_ && heard_.seq == 0) return f.times < kFirstWords;
  return loss_ >= kLossy && f.times == 1;
}

// What is not acknowledged is to be soon, and for that the other end must hear that it is not.
Tick OutLink::interval(const Context& c, std::uint32_t end) const {
  const bool quiet = c.quiet && acked_ >= end && loss_ < kUnquiet;
  const Tick marks = c.calm && loss_ < kLossy ? kCalmMarkInterval : quiet ? kQuietMarkInterval : kMarkInterval;
  const Tick silence = unanswered(c.now);
  // An answer may take a mark of ours and then one of the other end.
  if (silence < 2 * marks) return marks;
  Tick probes = marks;
  for (const Probing& p : kProbing)
    if (silence >= p.unanswered) probes = p.interval;
  return probes;
}

void OutLink::empty_packet() {
  std::vector<Bundle> updates = std::move(packet_.updates);
  for (Bundle& b : updates) pool_.give_back(std::move(b));
  updates.clear();
  packet_ = {};
  packet_.updates = std::move(updates);
}

// Where everybody begins at once, all would go on sending their marks in the same tick. So the first one is early, and
// they come in the peer's own phase. Who has just come in is waited for, and begins at once.
void OutLink::begin_marks(Tick now) {
  if (last_sent_ != kNever || fresh_) return;
  rate_.begin_window();
  last_sent_ = now - 1;
  marked_ = true;
}

// Where everybody falls quiet at once, the marks of a row get back into phase: each a little early, or one as early as
// need be where acknowledgements are urgent. Elsewhere on a narrow link none is early: it takes no more.
bool OutLink::mark_is_due(const Context& c) const {
  const Tick since = c.now - last_sent_;
  const bool at_once = seq_ == 0 || interval_ <= kMarkInterval;
  const Tick earliest = at_once ? 1 : interval_ - (rate_.is_limited() ? 0 : interval_ / 8);
  const Tick to_go = (interval_ - (c.now + c.phase) % interval_) % interval_;
  return since >= interval_ || (marked_ && since >= earliest && (to_go == 0 || since + to_go > interval_));
}

// Newest first: it matters most to what is seen. But where the other end cannot acknowledge all that it has one by one,
// that would be repeated for ever, and what it waits for would never get its turn. Where not all fits, the oldest is
// the first every other time: on a link that only just takes what is new it would never get its turn, either.
void OutLink::line_up(std::uint32_t oldest, std::uint32_t end) {
  lined_up_.clear();
  for (std::uint32_t i = end; i-- > oldest;) lined_up_.push_back(i);
  if (oldest_first_) {
    std::reverse(lined_up_.begin(), lined_up_.end());
  } else if (lined_up_.size() > kAcknowledged) {
    std::reverse(lined_up_.begin() + 1, lined_up_.end());
  }
}

bool OutLink::fits(std::size_t bytes, std::size_t room) {
  if (used_ > 0 && used_ + bytes > room) return false;
  used_ += bytes;
  return true;
}

// Nothing new has arrived for so long as far as is known, though some update has been under way for as long. The other
// end answers an update within a mark.
bool OutLink::is_silent(const Context& c, const Ring<Bundle>& own, std::uint32_t first) const {
  const Tick silence = unanswered(c.now);
  if (silence >= kSilent) return true;
  const Tick patience = kAnswered + slow_round_trip() + rate_.mark_interval(mark_bytes_);
  if (silence < patience) return false;
  const auto end = first + static_cast<std::uint32_t>(own.size());
  for (std::uint32_t i = std::max(acked_, first); i < end; ++i)
    if (!arrived(i)) return c.now - own[i - first].tick >= patience;
  return false;
}

// On a silent link nothing is repeated but the update that was sent longest ago, with whatever goes out: the link may
// work in this direction only, or by a carrier that the other end does not know, as it lacks that one's admission.
bool OutLink::choose(const Context& c, const Ring<Bundle>& own, std::uint32_t first, const SizeOf& size_of,
                     std::size_t room) {
  const bool silent = is_silent(c, own, first);
  bool urgent = false;
  used_ = 0;
  repeated_.clear();
  chosen_.clear();
  stalest_.reset();
  left_out_ = false;
  line_up(std::max(acked_, first), first + static_cast<std::uint32_t>(own.size()));
  for (const std::uint32_t i : lined_up_) {
    if (arrived(i)) continue;
    const Flight& f = flight(i);
    if (silent && f.times > 0) {
      if (!stalest_ || f.sent < flight(*stalest_).sent) stalest_ = i;
      continue;
    }
    const Alone& alone = own[i - first].bodies.empty() ? kAlone : kBodiesAlone;
    const bool copy = loss_ >= alone.loss && f.times == 1 && c.now - f.sent >= alone.after;
    const bool must = f.times == 0 || copy || lost(f, c.now);
    if (must && fits(size_of(own[i - first]), room)) {
      urgent = true;
      chosen_.push_back(i);
    } else if (must) {
      left_out_ = true;
    } else if (echoes(f, c.now)) {
      repeated_.push_back(i);
    }
  }
  return urgent;
}

// Marks so far apart may be all that a link carries, as it is estimated. Once, nothing but marks was sent for 8 s on
// one that carried a thousand times as much. The update that has waited longest goes with each of them.
void OutLink::choose_least() {
  const bool tells = interval_ >= LinkRate::kLongestMarkInterval && !chosen_.empty();
  if (tells) chosen_.front() = *std::min_element(chosen_.begin(), chosen_.end());
  chosen_.resize(tells ? 1 : 0);
  if (tells) stalest_.reset();
  repeated_.clear();
  used_ = 0;
}

StatePacket* OutLink::compose(const Context& c, const Ring<Bundle>& own, std::uint32_t first, const SizeOf& size_of,
                              std::size_t room) {
  const auto end = first + static_cast<std::uint32_t>(own.size());
  if (answered_at_ == kNever) answered_at_ = c.now;
  // Marks give way to updates where the link is narrow.
  interval_ = std::max(interval(c, end), rate_.mark_interval(mark_bytes_));
  begin_marks(c.now);
  const bool urgent = choose(c, own, first, size_of, room);
  gap_since_ = c.gap ? (gap_since_ < 0 ? c.now : gap_since_) : -1;
  const bool asks = c.again || missed_ || (gap_since_ >= 0 && c.now - gap_since_ >= kGapPatience);
  const bool ask = asks && c.now - last_sent_ >= kGapPatience;
  if (!urgent && !ask && !mark_is_due(c)) return nullptr;
  // Without answers nobody would learn that what is taken for a queue is none, or is over.
  const bool only_mark = !rate_.may_send(c.now);
  if (only_mark && !mark_is_due(c)) return nullptr;
  if (only_mark) choose_least();
  if (stalest_) repeated_.push_back(*stalest_);
  for (const std::uint32_t i : repeated_)
    if (fits(size_of(own[i - first]), room)) chosen_.push_back(i);
  empty_packet();
  StatePacket& p = packet_;
  p.seq = ++seq_;
  p.mark_tick = c.now;
  p.mark_count = end;
  p.have = c.have;
  p.have_beyond = c.have_beyond;
  tell_heard(c.now);
  p.seen_seq = told_.seq;
  p.seen_age = static_cast<std::uint32_t>(std::max(0, c.now - told_.at));
  take_chosen(c.now, own, first);
  last_sent_ = c.now;
  missed_ = false;
  oldest_first_ = left_out_ && !oldest_first_;
  marked_ = !urgent || only_mark;
  return &p;
}

// What came while this peer stood still is told of when its ticks have got there, as ages are not negative. A peer that
// is always behind tells of one after the other.
void OutLink::tell_heard(Tick now) {
  if (due_.at > now) return;
  told_ = heard_.at <= now ? heard_ : due_;
  due_ = heard_;
}

// They are on their way now.
void OutLink::take_chosen(Tick now, const Ring<Bundle>& own, std::uint32_t first) {
  std::sort(chosen_.begin(), chosen_.end());
  for (const std::uint32_t i : chosen_) {
    Flight& f = flight(i);
    if (f.times > 0) ++repeats_;
    f.sent = now;
    ++f.times;
    packet_.updates.push_back(pool_.copy(own[i - first]));
  }
}

void OutLink::on_packet(const StatePacket& p, Tick now) {
  if (p.seq > heard_.seq) {
    if (heard_.seq == 0) rate_.begin_window();
    if (p.updates.empty()) loss_ = p.loss;
    heard_ = {p.seq, now};
    if (due_.seq == told_.seq) due_ = heard_;
  }
  if (p.have > acked_) {
    for (std::uint32_t i = acked_; i < p.have && !flights_.empty(); ++i) flights_.pop_front();
    acked_ = p.have;
    acked_beyond_ = p.have_beyond;
  } else if (p.have == acked_) {
    acked_beyond_ |= p.have_beyond;
  }
  if (p.seen_seq <= newest_seen_) missed_ = last_were_missed(now);
  // Nobody has had anything for longer than there has been a session.
  const bool is_possible = p.mark_tick >= 0 && p.seen_age <= static_cast<std::uint32_t>(p.mark_tick);
  if (p.seen_seq <= newest_seen_ || p.seen_seq > seq_ || !is_possible) return;
  newest_seen_ = p.seen_seq;
  answered_at_ = now;
  const std::uint32_t back = seq_ - p.seen_seq;
  if (back >= rate_.remembered()) return;
  newest_seen_sent_ = rate_.sent_at(back);
  rate_.acknowledged(back);
  if (sample(static_cast<float>(now - newest_seen_sent_) - static_cast<float>(p.seen_age)))
    rate_.arrived(back, p.mark_tick - static_cast<Tick>(p.seen_age), now, srtt_, std::min(loss_, 90U) / 100.0);
}

void OutLink::left(std::size_t bytes, Tick now, bool late) {
  if (packet_.updates.empty()) mark_bytes_ = bytes;
  rate_.sent(bytes, now, late);
}

// Whether what was sent a round trip ago, and nothing since, has arrived. Whoever speaks meanwhile waits for it.
bool OutLink::last_were_missed(Tick now) const {
  const std::uint32_t unseen = seq_ - newest_seen_;
  if (unseen == 0 || unseen > rate_.remembered() || unanswered(now) < 2 * kMarkInterval) return false;
  return now - rate_.sent_at(unseen - 1) > static_cast<Tick>(std::ceil(srtt_ + 4 * rttvar_)) + 1;
}

// RFC 6298, in ticks. Either end may have stood still, which is no delay of the link: taken for one, a single such
// sample would put off repeats for seconds. A link that has really become so slow says so again and again.
bool OutLink::sample(float rtt) {
  rtt = std::max(0.0F, rtt);
  const bool stood_still = measured_ && rtt > srtt_ + 4 * rttvar_ + kStandstill;
  if (stood_still && ++standstills_ < kBelieved) return false;
  standstills_ = 0;
  if (!measured_) {
    measured_ = true;
    srtt_ = rtt;
    rttvar_ = rtt / 2;
    return true;
  }
  rttvar_ += (std::abs(srtt_ - rtt) - rttvar_) / 4;
  srtt_ += (rtt - srtt_) / 8;
  return true;
}

}  // namespace padr::sync
