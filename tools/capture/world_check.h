#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/capture/comparison.h"

namespace padr::capture {

/// The confirmed world of a tick, as it was rebuilt from a capture.
struct RebuiltWorld {
  std::uint64_t hash = 0;
  /// Incarnations that are members in it and that their peers gave up, as traces tell.
  std::vector<Incarnation> given_up;
};
using RebuiltWorlds = std::map<Tick, RebuiltWorld>;

/// One trace's confirmed worlds against those.
struct WorldCheck {
  std::string label;
  std::uint64_t compared = 0;
  std::uint64_t alike = 0;
  std::uint64_t beyond = 0;    ///< ticks that could not be rebuilt
  std::uint64_t given_up = 0;  ///< ticks of which the capture has a world that another trace's peer gave up
  bool superseded = false;
  Tick last = -1;  ///< that was compared
  Tick first_difference = -1;
};

/// By trace, in the order given.
std::vector<WorldCheck> check_worlds(const RebuiltWorlds& rebuilt, const std::vector<TraceStory>& traces);

}  // namespace padr::capture
