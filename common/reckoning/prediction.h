#pragma once

#include <vector>

#include "common/model/technique.h"
#include "common/sync/fold.h"
#include "common/world/view.h"

namespace padr::sync {

/// What the look-ahead says of the coming ticks.
struct Prediction {
  bool interaction = false;  ///< the avatar is expected to matter to bodies
  float level = 0;           ///< 0 .. 1: how much, for the continuous law
  float cost_m = 0;          ///< predicted physics-consistency cost in metres (pcc only)
  Tick contact_in = -1;      ///< ticks until the predicted contact, -1 if none
};

/// Looks at the avatar's surroundings and tells whether an interaction with bodies is near (paper, section III.d: a
/// threshold that adapts to a predicted physics-consistency cost). Look-aheads step a copy of what lies within a radius
/// of the avatar.
class InteractionPredictor {
 public:
  InteractionPredictor(const Scene& scene, int slots, PeerId self, const Technique& technique);
  ~InteractionPredictor();

  void retune(const Technique& technique) { technique_ = technique; }

  /// `live`: this peer's world as of now; `target`: where its avatar is driven; `modelled`: the predicted world's
  /// state, in which the avatar is where its model is.
  Prediction predict(const world::View& live, Vec2 target, const FoldState& modelled);

  /// Steps of copies so far: what the look-ahead costs.
  std::uint64_t steps() const { return steps_; }

 private:
  struct Run;
  /// An avatar and where it is driven, m and m/s.
  struct Course {
    Vec2 from;
    Vec2 velocity;
    Vec2 target;
  };
  /// Whether a body could be met on the way: false is certain, true is not.
  bool anything_in_the_way(const world::View& live, const Course& course) const;
  /// Puts the live world's surroundings of the avatar into the sandbox.
  void copy_surroundings(const world::View& live);
  Course believed_course(const FoldState& modelled) const;
  Prediction lookahead(Vec2 target);
  Prediction cost(const world::View& live, Vec2 target, const FoldState& modelled);
  Prediction density(const world::View& live, Vec2 target) const;
  Run run(Vec2 target);

  Scene scene_;
  PeerId self_;
  Technique technique_;
  world::World sandbox_;
  std::vector<bool> far_;  ///< by entity id: not copied
  std::uint64_t steps_ = 0;
};

}  // namespace padr::sync
