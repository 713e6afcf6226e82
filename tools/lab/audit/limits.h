#pragma once

#include <vector>

#include "common/model/scene.h"
#include "common/world/bounding_radius.h"

namespace padr::lab::audit {

/// What physics allows in a scene. Speeds are in m/s, and have the margins of margins.h.
class Limits {
 public:
  Limits(const Scene& scene, int slots);

  /// Of an avatar that touches nothing.
  float avatar_speed() const { return avatar_speed_; }
  /// Of an avatar in contact with avatars and bodies of these speeds.
  float avatar_speed_touching(float avatars, float bodies) const;
  float avatar_acceleration() const { return avatar_acceleration_; }  ///< m/s^2, of an avatar that touches nothing
  /// Of a body, where nothing else is faster than `fastest`.
  float body_speed(float fastest) const;

  /// Nothing of the entity is farther from its centre, m.
  float reach(EntityId e) const { return reaches_[e]; }
  /// m, from a point to the nearest obstacle or wall; 0 inside.
  float to_obstacle(Vec2 p) const;
  const Scene& scene() const { return *scene_; }

 private:
  const Scene* scene_;
  std::vector<float> reaches_;
  float avatar_speed_;
  float avatar_acceleration_;
  float fall_speed_;
  float restitution_;       ///< the highest of any two things
  float avatar_share_ = 0;  ///< of the change of speed in a contact with the heaviest body, that of the avatar
};

}  // namespace padr::lab::audit
