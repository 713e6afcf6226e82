#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/model/hash.h"
#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::world {

/// Everything of a moving thing that a step depends on.
struct Kinematics {
  Vec2 position;         ///< m, of the centre of mass, which is the origin
  float angle = 0;       ///< rad
  Vec2 velocity;         ///< m/s
  float spin = 0;        ///< rad/s
  float sleep_time = 0;  ///< s below the sleep speeds
  bool awake = true;
  friend bool operator==(const Kinematics&, const Kinematics&) = default;
};

/// A contact's memory: Box2D's manifold with the impulses that warm starting begins from. Kept whole because contacts
/// between sleeping bodies are solved from it, unrefreshed, in the step in which something wakes them.
struct ContactState {
  struct Point {
    Vec2 local;  ///< m
    float normal_impulse = 0;
    float tangent_impulse = 0;
    std::uint32_t id = 0;
    friend bool operator==(const Point&, const Point&) = default;
  };
  std::uint32_t key = 0;  ///< the two ends' slots in the world, the lower one in the upper half
  Vec2 local_normal;
  Vec2 local_point;
  std::array<Point, 2> points{};
  std::uint8_t type = 0;
  std::uint8_t count = 0;  ///< points in use
  bool touching = false;
  friend bool operator==(const ContactState&, const ContactState&) = default;
};

/// Of a contact's key: the end with the lower slot.
inline EntityId first_of(std::uint32_t contact_key) {
  return static_cast<EntityId>(contact_key >> 16U);
}
/// The other one; beyond the entities for something fixed.
inline EntityId second_of(std::uint32_t contact_key) {
  return static_cast<EntityId>(contact_key & 0xFFFFU);
}

/// The exact state of a World: restoring it into any World built from the same scene plays out bit for bit alike.
struct Snapshot {
  std::vector<Kinematics> entities;    ///< by entity id, avatar slots last
  std::vector<ContactState> contacts;  ///< those that touch, by key
  /// Keys of those that touched in the step that led here and have parted in it. Not a part of the state, but with
  /// `contacts` it says who had to do with whom in that step.
  std::vector<std::uint32_t> parted;
};

/// By key, as a snapshot has them.
void sort_by_key(std::vector<ContactState>& contacts);

/// Adds every bit of the snapshot, contact memory included.
void add_to_hash(WideHasher& h, const Snapshot& s);

}  // namespace padr::world
