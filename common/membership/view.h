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

  /// Ticks since the last one for which all updates of p are here, or since silence was last excused; 0 if none of p is
  /// awaited. Every confirmed world lies back as far.
  Tick arrears(PeerId p) const { return std::max(0, roster.now - std::max(log.complete(p), roster.seats[p].excused)); }
};

}  // namespace padr::node
