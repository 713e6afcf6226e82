#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/model/scene.h"

namespace padr::test {

/// Where a fighter wants its avatar to be, m, from the time in seconds alone.
using Script = std::function<Vec2(double seconds)>;

/// Two peers and something that both want.
struct Arena {
  std::string name;
  Scene scene;
  std::vector<Script> scripts;  ///< by peer
  double seconds = 0;
};

/// Both touch one body for the first time in the same tick.
Arena same_tick();
/// The second touches it two ticks after the first: later than the first on any link, sooner than it hears of it on a
/// slow one.
Arena within_the_latency();
/// Both push the same body against each other for seconds, at angles that keep changing.
Arena pushed_from_both_sides();
/// Each pushes a row of bodies, and the rows meet head on.
Arena two_stacks_meet();
/// A light ball in a narrow lane is hit back and forth.
Arena volley();

std::vector<Arena> arenas();

}  // namespace padr::test
