#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/sync/fold.h"
#include "common/world/view.h"

namespace padr::sync {

/// What the user sees and plays in: the own avatar moved by real input and touching everything, bodies under own
/// authority moved by real contacts, and everything else taken from the predicted world.
///
/// Only what may have to do with the own entities in a step is stepped: they, what they come near, and what that
/// touches. Everything else comes out as in the predicted world, which has just made the same step.
class LiveWorld {
 public:
  LiveWorld(const Scene& scene, const FoldState& start, PeerId self, bool authority);

  /// Takes over the predicted state of all that is not this peer's own. `own` is by entity id; `same`: the own ones are
  /// as predicted, and the memory of their contacts is taken over, too.
  /// `as_stepped`: nothing has changed in `predicted` since the last step was given it.
  void adopt(const FoldState& predicted, const std::vector<bool>& own, bool same, bool as_stepped = false);
  /// Where an entity has been moved from by the last adopt, as seen from where it is now, m.
  struct Jump {
    EntityId entity = 0;
    Vec2 from;
  };
  const std::vector<Jump>& jumps() const { return jumps_; }
  /// Advances one tick with the own avatar driven towards `target` (m). `predicted` has made the same step.
  void step(Vec2 target, const FoldState& predicted);

  /// Puts the own avatar there: another world moves it.
  void place(const BodyState& s);
  /// Adds to the own avatar's velocity, m/s.
  void jolt(Vec2 velocity);
  /// As step, but that the own avatar is not driven.
  void step_led(const FoldState& predicted);

  /// Adds to a body's velocity, m/s; no body gets faster than 60 m/s, half of what Box2D can do.
  void push(EntityId b, Vec2 velocity);

  /// What this peer has just told to be at rest is at rest here too: a neighbour that others own, sleeping and put back
  /// to sleep every tick, would keep Box2D from letting it sleep.
  void settle(const Bundle& told);

  /// Everything, as of now. After `adopt` its contacts are predicted's, whose memory the next step goes on from.
  const world::View& world() const { return view_; }
  /// Entities that touched in the last step, if only within it; sorted: what this peer has seen, whatever is adopted.
  const std::vector<Contact>& touching() const { return touching_; }
  PeerId self() const { return self_; }
  EntityId avatar() const { return view_.avatar(self_); }
  /// As adopted last.
  const Residents& residents() const { return residents_; }

 private:
  struct Placed {
    EntityId entity;
    Vec2 at;      ///< m
    float reach;  ///< m
  };
  void take_tables(const FoldState& predicted);
  void adopt_entity(EntityId e, const world::Kinematics& there);
  void advance(std::optional<Vec2> target, const FoldState& predicted);
  void place_moving(EntityId b, Vec2 v);
  void gather(const FoldState& predicted);
  void gather_near();
  bool gather_touching(const std::vector<world::ContactState>& contacts);
  bool join(EntityId a, EntityId b);
  void take(EntityId e);
  bool may_touch(EntityId own, EntityId other) const;
  void enter();
  void rest(EntityId e, const BodyState& s);
  void look(const FoldState& predicted);

  world::World world_;  ///< has those of stepped_, as of the last step
  world::View view_;
  PeerId self_;
  bool authority_;
  Tick tick_ = 0;
  std::vector<AvatarModel> avatars_;
  std::vector<PeerSet> holds_;
  std::vector<float> reach_;  ///< by entity, m: nothing of it is farther from its centre
  std::vector<Jump> jumps_;
  std::vector<EntityId> own_;
  std::vector<Placed> near_;  ///< the own, where they are
  bool same_ = true;
  std::vector<EntityId> stepped_;
  std::vector<EntityId> changed_;  ///< what has been done to it since, not by a step
  std::vector<EntityId> before_;
  std::vector<EntityId> taken_;  ///< of stepped_: as predicted
  std::vector<bool> out_;        ///< by entity: not in stepped_
  std::vector<bool> keep_;       ///< by entity: as it is in world_, or not there
  world::Snapshot mine_;
  std::vector<Contact> touching_;
  Residents residents_;
};

}  // namespace padr::sync
