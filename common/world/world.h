#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/model/scene.h"
#include "common/model/state.h"
#include "common/world/snapshot.h"

namespace padr::world {

/// One deterministic Box2D world of a scene: bodies, fixed obstacles, and an avatar slot for every peer there may be.
///
/// A step is made a function of what Snapshot holds and of nothing else. Box2D lets a step depend on more: on the order
/// in which contacts were found, and on what its contacts remember. Before each step the contact lists are therefore
/// put into the order of their keys, and snapshots carry the contacts' memory. So a world that is rewound and replayed,
/// a fresh world that is given a snapshot, and one that was only ever stepped forward, stay identical to the bit.
class World {
 public:
  /// `slots`: avatar slots to create, 0 .. kMaxPeers; they start absent, at their spawn points.
  World(const Scene& scene, int slots);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  int bodies() const { return bodies_; }
  int slots() const { return slots_; }
  int entities() const { return bodies_ + slots_; }
  EntityId avatar(PeerId p) const { return static_cast<EntityId>(bodies_ + p); }
  bool is_avatar(EntityId e) const { return e >= bodies_; }
  const Scene& scene() const { return *scene_; }

  /// An absent thing touches nothing and does not move. Bodies start present, avatars absent.
  void set_present(EntityId e, bool present);
  bool present(EntityId e) const;
  /// A held body is one that a modelled avatar is known to touch; the avatar collides with no other body.
  void set_hold(PeerId p, EntityId body, bool held);
  bool hold(PeerId p, EntityId body) const;
  /// A free avatar collides with every body, held or not: the one that this peer drives.
  void set_free(PeerId p, bool free);

  BodyState state(EntityId e) const {
    const Kinematics& k = seen_[e];
    return {k.position, k.angle, k.velocity, k.spin, k.awake};
  }
  Vec2 position(EntityId e) const { return seen_[e].position; }  ///< m
  Vec2 velocity(EntityId e) const { return seen_[e].velocity; }  ///< m/s
  bool awake(EntityId e) const { return seen_[e].awake; }
  /// How many things the last step had to look at: what is awake, and what that may wake.
  std::size_t listed() const;
  /// Overwrites transform, then velocity, then sleep flag. Skipped when equal: overwriting with the same is not a
  /// no-op.
  void set_state(EntityId e, const BodyState& s);
  /// m/s; wakes the entity if not zero.
  void set_velocity(EntityId e, Vec2 v);
  /// N, at the centre, for the next step; wakes the entity.
  void apply_force(EntityId e, Vec2 force);

  /// Advances one tick. Nothing gets further than kMostOutside out of the play area: there it stops.
  void step();
  /// Entities that touch, sorted, as of the last step.
  const std::vector<Contact>& contacts() const;

  const Kinematics& kinematics(EntityId e) const { return seen_[e]; }
  void save(Snapshot& out) const;
  /// So many contacts, as many as entities, have room in every snapshot that is saved: piece by piece room would be
  /// found anew for each of the many that are kept.
  std::size_t usual_contacts() const;
  /// Of the snapshot only `contacts` and `parted`.
  void save_contacts(Snapshot& out) const;
  /// Takes over the snapshot's state exactly, but leaves entities whose bit in `keep` is set as they are, with the
  /// memory of their contacts. `keep` is indexed by entity id; empty keeps nothing. The snapshot must come from a world
  /// of the same scene and slots. Holds and presence are the caller's to set first.
  void restore(const Snapshot& s, const std::vector<bool>& keep = {});
  /// The same if all but `which` are kept.
  void restore_only(const Snapshot& s, const std::vector<EntityId>& which, const std::vector<bool>& keep);

 private:
  struct Box2d;
  std::unique_ptr<Box2d> impl_;
  /// Puts it back where the scene's surroundings end, if it has got further.
  void keep_in_reach(EntityId e);

  std::unique_ptr<Scene> scene_;
  Area reach_;
  const Kinematics* seen_ = nullptr;  ///< by entity id
  int bodies_ = 0;
  int slots_ = 0;
};

}  // namespace padr::world
