#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/link/distribution.h"
#include "common/link/loss.h"
#include "common/link/netem_spec.h"
#include "common/model/ids.h"
#include "common/model/rng.h"

namespace padr::link {

/// Bytes that IPv4 and UDP headers add to a payload; `rate`, `slot bytes` and `trace` count them, as a network would.
inline constexpr std::size_t kHeaderBytes = 28;

/// What a shim did, in datagrams. At any time
/// accepted + duplicated == released + lost + overlimit + Shim::in_flight().
struct ShimStats {
  std::uint64_t accepted = 0;
  std::uint64_t released = 0;
  std::uint64_t lost = 0;            ///< by the loss model
  std::uint64_t duplicated = 0;      ///< clones made; a clone may be lost in its turn
  std::uint64_t corrupted = 0;       ///< one bit flipped; an empty payload has none to flip
  std::uint64_t reordered = 0;       ///< sent at once, past those delayed, by `reorder`
  std::uint64_t overlimit = 0;       ///< dropped because `limit` datagrams were held
  std::uint64_t accepted_bytes = 0;  ///< payload bytes
  std::uint64_t released_bytes = 0;
  friend bool operator==(const ShimStats&, const ShimStats&) = default;
};

/// One directed link that behaves as tc-netem: datagrams go in, and come out later, or not, or twice, or broken.
///
/// Per datagram, in netem's order: duplicate, loss, (the clone goes through all of this first, duplicate off),
/// corrupt, limit, reorder, delay, rate, slot or trace. See shim.cpp.
///
/// Where it differs from the kernel: only the payload is corrupted, so UDP's checksum does not hide the damage from
/// the receiver (harsher); each knob draws from a stream of its own, so turning one does not change the others' draws.
///
/// Pure: it has no clock. `now` is microseconds on any clock of the caller's, the same for all calls, within +-2^52;
/// a `now` earlier than one before is taken as that one. What comes out, and in which order, depends on the datagrams,
/// the times at which they were accepted and the seed, not on how often release() is called.
class Shim {
 public:
  /// `seed` is the link's own; `spec.seed` changes its streams if it is set. Two shims of the same spec and seed do the
  /// same.
  Shim(const NetemSpec& spec, std::uint64_t seed);

  /// A datagram enters the link at `now`.
  void accept(Micros now, std::span<const std::byte> datagram);

  /// True if a datagram that enters at `now` leaves at once, unchanged and before anything else, as links without rules
  /// let it: then it counts as accepted and released, and the caller has it already. Otherwise nothing has happened.
  bool pass(Micros now, std::span<const std::byte> datagram);

  /// The next datagram that has left the link by `now`, in the order of leaving; call until it returns nothing.
  std::optional<std::vector<std::byte>> release(Micros now);

  /// When to call release() next, rounded up to a whole microsecond; may be past. Nothing if no datagram is held.
  /// With `slot`, or of a datagram longer than an opportunity of a trace, a call at that time may yield nothing yet and
  /// a later time.
  std::optional<Micros> next_due() const;

  /// New rules from `now` on. Datagrams held keep their times; chains, gap count and slots begin anew, a trace stays
  /// where the clock is; random streams go on, unless `spec.seed` is set, which restarts them.
  void set_spec(Micros now, const NetemSpec& spec);

  const NetemSpec& spec() const { return spec_; }
  const ShimStats& stats() const { return stats_; }
  /// Datagrams accepted but neither released nor dropped.
  std::size_t in_flight() const { return queue_.size() + left_.size(); }

 private:
  using Bytes = std::vector<std::byte>;
  struct Left {
    Nanos at;
    Bytes bytes;
  };
  /// Every source of chance, each its own stream.
  struct Draws {
    Draws(std::uint64_t seed, const NetemSpec& spec);
    void set_spec(const NetemSpec& spec);
    LossProcess loss;
    CorrelatedRandom duplicate, corrupt, reorder, delay;
    Rng bit, slot, trace;
  };
  /// One line of the trace, in one of its repetitions.
  struct Opportunity {
    Nanos repetition;  ///< when that began
    std::size_t line;
    friend auto operator<=>(const Opportunity&, const Opportunity&) = default;
  };

  void enter(Bytes bytes, bool may_duplicate);
  void corrupt(Bytes& bytes);
  void schedule(Bytes bytes);
  Nanos transmission_time(std::size_t payload) const;
  void run_until(Nanos now);
  void dequeue();
  void leave(Bytes bytes);
  void count_in_slot(std::size_t payload);
  void open_slot();
  bool traced() const { return spec_.trace.opportunities != nullptr; }
  void begin_trace();
  Opportunity opportunity_for(Nanos due) const;
  Nanos time_of(const Opportunity& o) const;
  bool carry(Nanos due, std::size_t payload);
  Nanos wake_time() const;

  NetemSpec spec_;
  bool perfect_;        ///< no rules
  std::uint64_t seed_;  ///< the link's own
  Draws draws_;
  ShimStats stats_;
  Nanos now_;
  std::multimap<Nanos, Bytes> queue_;  ///< by time to send; equal times in order of arrival
  std::deque<Left> left_;              ///< out of the link, not yet collected
  std::uint32_t since_reorder_ = 0;
  Nanos slot_next_;
  std::int64_t slot_packets_ = 0;
  std::int64_t slot_bytes_ = 0;
  Nanos trace_began_ = 0;     ///< its first repetition
  Opportunity next_{};        ///< the first one with room left
  std::int64_t room_ = 0;     ///< bytes left in it
  std::int64_t carried_ = 0;  ///< bytes of the queue's head that earlier ones have taken
};

}  // namespace padr::link
