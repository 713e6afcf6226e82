#pragma once

#include <optional>
#include <vector>

#include "common/model/ids.h"

namespace padr::node {

/// What the coordinator knows of a peer that does not answer it.
struct Hearsay {
  Tick now = 0;
  Tick unanswered = 0;          ///< ticks without a sign of life of it, by whatever way
  std::optional<Tick> refused;  ///< since when its machine has said that nobody listens there
  bool given_up = false;        ///< it is not to stay, whoever hears it
  bool deaf = false;            ///< it is heard here: it says itself that nothing of ours arrives, by whatever way
  /// By each of those whose word counts: tick of the newest mark by which the peer itself has answered it, -1 if there
  /// is none; nothing: it has not said yet.
  std::vector<std::optional<Tick>> heard;
};

/// Others are asked whether they hear a peer when it has not answered for so many ticks, so that their answers are here
/// when it would be declared gone.
inline constexpr Tick kDoubt = 120;
/// Nobody who has answered within so many ticks is declared gone.
inline constexpr Tick kSilence = 3 * kTicksPerSecond;
/// Who has been asked for so many ticks and has not answered is taken not to hear it.
inline constexpr Tick kAnswerPatience = 72;
/// Who has such a mark that is younger than this hears the peer, and is heard by it: one that is heard, but hears
/// nothing, is of no use.
inline constexpr Tick kHeardLately = 120;
/// Anybody can say that it hears somebody, for ever. What proves it are updates: nobody can sign another's. A peer that
/// somebody hears goes on telling updates, and they are relayed. So words alone keep nobody in for longer than this,
/// which is less than Guard::kArrears.
inline constexpr Tick kBelieved = 7 * kTicksPerSecond;

/// Whether somebody says that it hears the peer.
bool is_heard(const Hearsay& h);
/// Whether the peer may be declared gone: nobody hears it, or it takes nothing from us though others could relay it, as
/// one does that is about to declare us gone.
bool may_evict(const Hearsay& h);

}  // namespace padr::node
