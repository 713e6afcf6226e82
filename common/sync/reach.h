#pragma once

#include <cstdint>
#include <vector>

#include "common/model/ids.h"
#include "common/model/scene.h"
#include "common/world/snapshot.h"

namespace padr::sync {

// For playing some entities of a world apart from the others.

/// By entity id, m: nothing of it is farther from its centre, nor touches anything that is. Bodies, then avatar slots.
std::vector<float> reaches(const Scene& scene, int slots);

inline EntityId first_of(std::uint32_t contact_key) {
  return static_cast<EntityId>(contact_key >> 16U);
}
/// Beyond the entities for something fixed.
inline EntityId second_of(std::uint32_t contact_key) {
  return static_cast<EntityId>(contact_key & 0xFFFFU);
}

/// Puts the contacts of `part` in place of those in `into` of entities whose bit in `left_out` is clear.
void replace_contacts(world::Snapshot& into, const world::Snapshot& part, const std::vector<bool>& left_out);

}  // namespace padr::sync
