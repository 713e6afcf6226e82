#pragma once

#include <cstddef>
#include <vector>

#include "common/model/scene.h"
#include "common/model/state.h"
#include "common/world/snapshot.h"

namespace padr::world {

/// Where everything of a scene is: what can be looked at in a world, however it is computed.
class View {
 public:
  /// `scene` must outlive it.
  View(const Scene& scene, int slots) : scene_(&scene), bodies_(static_cast<int>(scene.bodies.size())), slots_(slots) {
    what_.entities.resize(static_cast<std::size_t>(entities()));
    present_.assign(what_.entities.size(), 1);
  }

  int bodies() const { return bodies_; }
  int slots() const { return slots_; }
  int entities() const { return bodies_ + slots_; }
  EntityId avatar(PeerId p) const { return static_cast<EntityId>(bodies_ + p); }
  bool is_avatar(EntityId e) const { return e >= bodies_; }
  const Scene& scene() const { return *scene_; }

  /// An absent thing touches nothing and does not move.
  bool present(EntityId e) const { return present_[e] != 0; }
  BodyState state(EntityId e) const {
    const Kinematics& k = what_.entities[e];
    return {k.position, k.angle, k.velocity, k.spin, k.awake};
  }
  Vec2 position(EntityId e) const { return what_.entities[e].position; }  ///< m
  Vec2 velocity(EntityId e) const { return what_.entities[e].velocity; }  ///< m/s
  bool awake(EntityId e) const { return what_.entities[e].awake; }
  /// Of every entity, by id.
  const std::vector<Kinematics>& kinematics() const { return what_.entities; }
  /// Entities that touch, sorted, as of the last step; worked out when it is asked for.
  const std::vector<Contact>& contacts() const;
  /// All of it, contacts' memory included.
  const Snapshot& snapshot() const { return what_; }

  /// For whoever computes it: to be filled in. What `contacts` has returned is void.
  Snapshot& change() {
    contacts_known_ = false;
    return what_;
  }
  void set_present(EntityId e, bool present) { present_[e] = present ? 1 : 0; }

 private:
  const Scene* scene_;
  int bodies_;
  int slots_;
  Snapshot what_;
  std::vector<char> present_;
  mutable std::vector<Contact> contacts_;
  mutable bool contacts_known_ = false;
};

}  // namespace padr::world
