#pragma once

#include <box2d/box2d.h>

#include "common/world/snapshot.h"

namespace padr::world {

inline Vec2 from_b2(b2Vec2 v) {
  return {v.x + 0.0F, v.y + 0.0F};
}  // + 0 turns -0 into +0
inline b2Vec2 to_b2(Vec2 v) {
  return {v.x, v.y};
}

// What a contact remembers from one step to the next.

/// Fills in all of `s`. A state that is made elsewhere and then copied has to wait for what has just been written.
void read_contact(b2Contact& c, ContactState& s);
void write_contact(b2Contact& c, const ContactState& s);
void forget_contact(b2Contact& c);
/// Whether there is anything to forget.
bool remembers(b2Contact& c);

/// Whether the two shapes' bounds overlap where they are now: unlike Box2D's own enlarged bounds, a function of the
/// state alone.
bool bounds_overlap(const b2Contact& c);

}  // namespace padr::world
