#pragma once

#include <vector>

#include "common/model/ids.h"
#include "common/model/technique.h"
#include "common/model/vec.h"
#include "common/shown/clearance.h"
#include "common/world/view.h"

namespace padr::sync {

/// What is shown, apart from what is simulated: when an update moves an entity to where it was not expected, the shown
/// position is led there instead of jumping.
///
///   snap   it jumps
///   blend  what the correction moved it by dies away exponentially: at once fast, then ever slower
///   pvb    projective velocity blending (Murphy, "Believable dead reckoning for networked games"): from the course it
///          was shown on to the true one, within a time that grows with the error, so that it never seems to be thrown
///   track  as fast as its step may change: time-optimal control of the offset, planned anew at each tick from what is
///          shown, so that a correction does not begin anything again. Kept out of other things; if there is a wall
///          in between, it jumps
///
/// Corrections concern what others own. The own is shown as it is, but for a blend that runs already when it becomes
/// the own.
class Shown {
 public:
  Shown(Convergence how, const Scene& scene, int slots);
  /// Before the first advance: what is shown is the live world as it begins.
  void begin(const std::vector<world::Kinematics>& live);
  /// Goes on another way; what is being led goes on being led from where it is shown, but for kSnap. `live`: as in the
  /// last advance.
  void retune(Convergence how, const std::vector<world::Kinematics>& live);

  /// An update (not physics) has moved an entity in the live world, from `jump` metres away from where it is now; may
  /// be called several times a tick.
  void correct(EntityId e, Vec2 jump) {
    jump_[e] = jump_[e] + jump;
    busy_[e] = 1;
  }
  /// One tick. `live`: the live world; `own`: by entity id.
  void advance(const world::View& live, const std::vector<bool>& own);

  const std::vector<Vec2>& positions() const { return shown_; }

  /// Jumps as a viewer sees them: how far a shown position moved in one tick beyond what is explained by the entity's
  /// velocity, by the way it was shown to move in the tick before, or by a change from the one to the other (a bounce).
  /// Those of more than 3 cm so far, their sum and the largest, in metres.
  int snaps() const { return snaps_; }
  double snap_metres() const { return snap_metres_; }
  double largest_snap() const { return largest_snap_; }

 private:
  struct Blend {
    Vec2 from;      ///< m, goes on with the course it was shown on
    Vec2 velocity;  ///< m/s, that course when the blend began
    int age = -1;   ///< ticks into the blend, -1 when none runs
    int ticks = 0;  ///< that it takes
  };
  Vec2 lead(std::size_t e, Vec2 live, Vec2 velocity, bool own);
  Vec2 exponential(std::size_t e, Vec2 live, bool corrected);
  Vec2 projective(std::size_t e, Vec2 live, Vec2 velocity, bool corrected);
  Vec2 track(std::size_t e, Vec2 live, Vec2 velocity, bool corrected);
  void stop(std::size_t e);
  void keep_clear(const world::View& live);
  void note(std::size_t e, Vec2 straight);
  void count_snap(Vec2 stride, Vec2 last_stride, Vec2 straight);

  Convergence how_;
  Clearance clearance_;
  std::vector<Vec2> shown_;
  std::vector<Vec2> before_;      ///< m, shown_ a tick ago
  std::vector<Vec2> stride_;      ///< m, what shown_ moved by in the last tick
  std::vector<Vec2> jump_;        ///< corrections of this tick: where it would have been, from where it is
  std::vector<Vec2> offset_;      ///< blend, track: what is left of the correction
  std::vector<Blend> blends_;     ///< pvb
  std::vector<char> busy_;        ///< has been corrected since the last tick, or is being led
  std::vector<EntityId> moving_;  ///< in this tick; these two: memory that is used again
  std::vector<EntityId> led_;
  bool first_ = true;
  int snaps_ = 0;
  double snap_metres_ = 0;
  double largest_snap_ = 0;
};

}  // namespace padr::sync
