#pragma once

#include <box2d/box2d.h>

#include <vector>

#include "common/model/ids.h"
#include "common/model/scene.h"
#include "common/world/snapshot.h"

namespace padr::bench {

/// The same scene in a Box2D world and nothing around it: what a step costs at least. The bodies are those of
/// world::World, which is left out with all that it does before and after a step.
class BareWorld final : b2ContactFilter {
 public:
  /// `own`: whose avatar touches whatever it meets, as in that peer's live world; kNoPeer: nobody's, as in a predicted
  /// one.
  BareWorld(const Scene& scene, int avatars, PeerId own = 0);

  /// Everything is there now; `holds` as in FoldState. What is there already is left alone.
  void put(const std::vector<world::Kinematics>& entities, const std::vector<PeerSet>& holds);
  void step() { world_.Step(kTickSeconds, velocity_iterations_, position_iterations_); }

 private:
  void add(const BodyDef& d, b2BodyType type, bool avatar);
  bool ShouldCollide(b2Fixture* a, b2Fixture* b) override;

  b2World world_;
  int velocity_iterations_;
  int position_iterations_;
  std::size_t n_bodies_;
  PeerId own_;
  std::vector<b2Body*> bodies_;
  std::vector<PeerSet> holds_;
};

}  // namespace padr::bench
