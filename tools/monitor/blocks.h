#pragma once

#include <string>
#include <vector>

#include "common/monitor/telemetry.h"
#include "tools/monitor/request.h"

namespace padr::monitor {

inline constexpr PeerId kNobody = 0xFF;  ///< slot of a view that is of no peer in particular

/// One view of the world, as a page gets it: page/PROTOCOL.md has the bytes.
struct Block {
  PeerId slot = kNobody;
  Which which = Which::kShown;
  bool interaction = false;
  bool paused = false;
  bool driven = false;
  Tick tick = 0;
  float threshold = 0;  ///< m; 0: not told
  Vec2 target;          ///< m; NaN: not told
};

/// Entities that are not present are left out. `at` is as long as `flags`, or longer.
std::string encode_block(const Block& head, const std::vector<EntityFlags>& flags, const std::vector<Place>& at);

}  // namespace padr::monitor
