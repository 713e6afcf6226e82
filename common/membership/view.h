#pragma once

#include <algorithm>

#include "common/model/scene.h"
#include "common/replica/roster.h"
#include "common/sync/update_log.h"

namespace padr::node {

/// What the rules of membership see of the agreed world: who is there, and whose updates have come.
struct View {
  const Roster& roster;
  const sync::UpdateLog& log;
  const Scene& scene;

  /// By how many ticks what p has told in full lies back, and with it everybody's confirmed world; 0 if nothing of it
  /// is waited for.
  Tick arrears(PeerId p) const { return std::max(0, roster.now - std::max(log.complete(p), roster.seats[p].excused)); }
};

}  // namespace padr::node
