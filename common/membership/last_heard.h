#pragma once

#include <optional>
#include <vector>

#include "common/model/ids.h"

namespace padr::node {

/// What the coordinator knows of a peer that does not answer it. All times in ticks.
struct LastHeard {
  Tick now = 0;
  Tick unanswered = 0;          ///< since its last sign of life, direct or relayed
  std::optional<Tick> refused;  ///< since when its machine has reported that nobody listens at the address
  bool given_up = false;        ///< it is evicted even if another member hears it
  bool deaf = false;            ///< we hear it, but it reports that it receives nothing of ours
  /// One entry for each member that counts: tick of the newest mark with which the peer has answered that member;
  /// -1: there is none; nothing: the member has not replied yet.
  std::vector<std::optional<Tick>> heard;
  /// When a poll was last taken back: later replies to earlier polls are ignored, and members are asked anew since.
  std::optional<Tick> taken_back;
};

/// Silence after which the coordinator asks the others when they heard the peer last. It is shorter than kSilence, so
/// that the replies are here in time.
inline constexpr Tick kDoubt = 120;
/// Silence before which nobody is evicted.
inline constexpr Tick kSilence = 3 * kTicksPerSecond;
/// Timeout for a reply. A member that does not reply counts as not hearing the peer.
inline constexpr Tick kAnswerPatience = 72;
/// Age up to which a mark shows that the member and the peer hear each other. A peer that is heard, but hears nothing,
/// cannot stay.
inline constexpr Tick kHeardLately = 120;
/// Lag from which on a peer counts as held up: it heard nobody because it did not listen.
inline constexpr Tick kHeldUp = 24;
/// Time for which replies alone keep a silent peer in. A member can claim for ever that it hears a peer; only updates
/// prove it, because nobody can sign another peer's. Less than View::kArrears.
inline constexpr Tick kBelieved = 7 * kTicksPerSecond;

/// Whether a member replied that it hears the peer.
bool is_heard(const LastHeard& h);
/// Whether the peer stays because a member replied so.
bool stays_by_word(const LastHeard& h);
/// Whether the peer may be evicted. Either no member hears it, or it takes nothing from us although others could relay
/// our updates: a peer that is about to evict us behaves like this.
bool may_evict(const LastHeard& h);

}  // namespace padr::node
