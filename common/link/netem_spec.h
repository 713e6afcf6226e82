#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace padr::link {

/// A probability or correlation in 32-bit fixed point, as netem keeps it: 0 is never, kAlways is 100 %.
using Chance = std::uint32_t;
inline constexpr Chance kAlways = 0xFFFFFFFFU;

/// Nanoseconds, netem's own resolution.
using Nanos = std::int64_t;
inline constexpr Nanos kNanosPerMicro = 1'000;
inline constexpr Nanos kNanosPerMilli = 1'000'000;
inline constexpr Nanos kNanosPerSecond = 1'000'000'000;

/// Ranges that the shim relies on; whoever reads a specification enforces them.
inline constexpr Nanos kMaxTime = 4'294 * kNanosPerSecond;  ///< what fits tc's 32-bit microseconds
inline constexpr Nanos kMaxJitter = 2'147'483'647;          ///< the kernel cuts jitter to a 32-bit int of nanoseconds
inline constexpr int kMaxOverhead = 65'535;                 ///< bytes, either sign; also the largest cell
inline constexpr std::uint64_t kMaxRate = 10'000'000'000'000ULL;  ///< bit/s

/// `P [CORRELATION]`: how often, and how much a draw resembles the one before it.
struct Knob {
  Chance chance = 0;
  Chance correlation = 0;
  friend bool operator==(const Knob&, const Knob&) = default;
};

/// Shape of a random delay around DELAY, in units of JITTER. Uniform is netem's real default (its manual page says
/// normal): every value in [DELAY - JITTER, DELAY + JITTER) alike. The others are tables, see distribution.h.
enum class Distribution : std::uint8_t { kUniform, kNormal, kPareto, kParetoNormal };

/// `delay TIME [JITTER [CORRELATION]] [distribution NAME]`.
struct DelaySpec {
  Nanos mean = 0;
  Nanos jitter = 0;
  Chance correlation = 0;
  Distribution distribution = Distribution::kUniform;
  friend bool operator==(const DelaySpec&, const DelaySpec&) = default;
};

/// `loss state P13 [P31 [P32 [P23 [P14]]]]`: chances to go from state to state, drawn once a packet. State 1 sends
/// (gap), 2 sends within a burst of losses, 3 loses in a burst, 4 loses one packet and returns to 1.
struct FourStateLoss {
  Chance p13 = 0, p31 = 0, p32 = 0, p23 = 0, p14 = 0;
  friend bool operator==(const FourStateLoss&, const FourStateLoss&) = default;
};

/// `loss gemodel P [R [1-H [1-K]]]` (Gilbert, Elliott): good to bad, bad to good, loss while bad, loss while good.
struct GilbertElliottLoss {
  Chance p = 0, r = 0, lose_bad = 0, lose_good = 0;
  friend bool operator==(const GilbertElliottLoss&, const GilbertElliottLoss&) = default;
};

/// `rate RATE [OVERHEAD [CELL [CELLOVERHEAD]]]`.
struct RateSpec {
  std::uint64_t bits_per_second = 0;  ///< 0: unlimited
  std::int32_t overhead = 0;          ///< bytes added to each packet; may be negative
  std::uint32_t cell = 0;             ///< bytes; packets are rounded up to whole cells; 0: no cells
  std::int32_t cell_overhead = 0;     ///< bytes added to each cell; may be negative
  friend bool operator==(const RateSpec&, const RateSpec&) = default;
};

/// `slot MIN [MAX]` or `slot distribution NAME DELAY JITTER`, then `[packets N] [bytes B]`: packets that are due wait
/// for the next slot, and a slot closes when it has sent N packets or B bytes.
struct SlotSpec {
  bool on = false;
  Nanos min = 0, max = 0;                    ///< uniform in [min, max) when `distribution` is absent
  std::optional<Distribution> distribution;  ///< otherwise around delay, in units of jitter
  Nanos delay = 0, jitter = 0;
  std::uint32_t packets = 0;  ///< 0: any number
  std::uint32_t bytes = 0;    ///< counted as packet_length() counts; 0: any number
  friend bool operator==(const SlotSpec&, const SlotSpec&) = default;
};

/// Bytes that one opportunity of a link trace carries: mahimahi's, a packet of 1,500 and 4 of its tunnel.
inline constexpr std::int64_t kOpportunityBytes = 1504;

/// `trace NAME|FILE [START|random]`: a recorded link, in the form of mahimahi's traces. Packets that are due wait for
/// opportunities. Each carries kOpportunityBytes, also of several packets or a part of one; what nobody uses is lost.
struct TraceSpec {
  /// Times of the opportunities in ms since the trace began: none is less than the one before, and the last is above 0.
  /// When that is over, the trace begins again. Null: no trace.
  std::shared_ptr<const std::vector<std::uint32_t>> opportunities;
  std::string name;                ///< NAME or FILE
  std::optional<Nanos> start = 0;  ///< where in the trace the clock's 0 is; nothing: the seed draws it
  friend bool operator==(const TraceSpec& a, const TraceSpec& b) {
    const bool same = a.opportunities == b.opportunities ||
                      (a.opportunities && b.opportunities && *a.opportunities == *b.opportunities);
    return same && a.name == b.name && a.start == b.start;
  }
};

/// What one directed link does to packets: the options of tc-netem(8), and link traces. Default constructed it is a
/// perfect link.
struct NetemSpec {
  std::uint32_t limit = 1000;  ///< packets held at most; more are dropped
  DelaySpec delay;
  std::variant<Knob, FourStateLoss, GilbertElliottLoss> loss;
  Knob corrupt;
  Knob duplicate;
  Knob reorder;
  std::uint32_t gap = 0;  ///< 0: no reordering; else every gap-th packet may be sent at once
  RateSpec rate;
  SlotSpec slot;
  TraceSpec trace;                    ///< with neither rate nor slot, which say when packets leave, too
  std::optional<std::uint64_t> seed;  ///< changes the streams of each link, which stay apart
  friend bool operator==(const NetemSpec&, const NetemSpec&) = default;
};

}  // namespace padr::link
