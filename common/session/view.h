#pragma once

#include <algorithm>

#include "common/model/scene.h"
#include "common/replica/roster.h"
#include "common/sync/update_log.h"

namespace padr::node {

/// What the membership rules see of the agreed world: the roster, the update log and the scene.
struct View {
  const Roster& roster;
  const sync::UpdateLog& log;
  const Scene& scene;
  PeerSet returning = 0;  ///< members that have asked this peer to let them in anew, and may take nothing from it

  /// Ticks since the last one for which all updates of p are here, or since silence was last excused; 0 if none of p is
  /// awaited. Every confirmed world lies back as far.
  Tick arrears(PeerId p) const {
    const Seat& s = roster.seats[p];
    return std::max(0, roster.now - std::max({log.complete(p), s.excused, s.forgiven}));
  }
  /// Whether the last of the first `count` updates of p's slot is of a tick that is over, or is kept no longer. Only
  /// then may the slot be given to another peer: what a clock that was ahead left would move that one's avatar.
  bool is_over(PeerId p, std::uint32_t count) const {
    const sync::Bundle* last = count > 0 ? log.find(p, count - 1) : nullptr;
    return last == nullptr || last->tick < roster.now;
  }
  /// Whether updates of a former occupant of p's slot are missing, which p cannot tell.
  bool lacks_former(PeerId p) const { return log.have(p) < roster.seats[p].first; }
  /// Whether p, though heard, has not told or not acknowledged updates for too long.
  bool delays(PeerId p) const { return arrears(p) >= kArrears || roster.unacknowledged(p) >= kArrears; }
  /// Whether updates of p have been missing for too long, whatever excuses that: p may be heard, but a newcomer that
  /// says so holds up an eviction which all others wait for.
  bool withholds(PeerId p) const { return !lacks_former(p) && roster.now - log.complete(p) >= kArrears; }
  /// Time for which a member that is heard may withhold promised updates, which hold up every confirmed world, or
  /// acknowledgements, without which updates must be kept.
  static constexpr Tick kArrears = 8 * kTicksPerSecond;
};

}  // namespace padr::node
