#pragma once

#include <box2d/box2d.h>

#include <cstdint>
#include <vector>

namespace padr::world {

inline std::uint32_t slot_of(const b2Body& b) {
  return static_cast<std::uint32_t>(const_cast<b2Body&>(b).GetUserData().pointer);
}

/// Slot numbers of the two bodies of a contact, the lower one in the upper half. Unique: one fixture per body.
std::uint32_t contact_key(const b2Contact& c);

/// Finds the contacts that the next step would find.
void find_contacts(b2World& world);

/// Puts the world's list and every body's list of contacts into
/// the order of the keys. The solver works through these lists, so its result is made independent of how they came
/// about. `scratch` is reused between calls.
void order_contacts(b2World& world, std::vector<b2Contact*>& scratch);

}  // namespace padr::world
