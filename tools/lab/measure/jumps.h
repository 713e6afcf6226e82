#pragma once

#include <cstdint>
#include <vector>

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::lab {

/// Jumps as one viewer sees them, of any technique: how far a shown position moved in one tick beyond what is explained
/// by the entity's velocity, by the way it was shown to move in the tick before, or by a change from the one to the
/// other (a bounce). The own avatar counts like everything else: a view that stood still and catches up jumps.
class JumpMeter {
 public:
  /// A tick: shown places (m) and the velocities (m/s) that things have in the view, by entity.
  void tick(const std::vector<Vec2>& shown, const std::vector<Vec2>& velocity);

  std::uint64_t jumps() const { return jumps_; }  ///< of more than 3 cm
  double metres() const { return metres_; }       ///< their sum
  double largest_m() const { return largest_m_; }

 private:
  std::vector<Vec2> before_;  ///< m, by entity
  std::vector<Vec2> stride_;  ///< m, what it moved by in the last tick
  std::uint64_t jumps_ = 0;
  double metres_ = 0;
  double largest_m_ = 0;
};

}  // namespace padr::lab
