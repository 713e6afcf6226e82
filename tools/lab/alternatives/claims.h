#pragma once

#include <cstdint>
#include <vector>

#include "common/model/ids.h"
#include "common/world/world.h"

namespace padr::lab::alternatives {

/// Who simulates a body for all others, as far as one peer knows.
struct Claim {
  PeerId owner = 0;            ///< of a body that nobody has touched: the lowest peer
  std::uint16_t sequence = 0;  ///< grows by one with each claim; wraps round
  bool held = false;           ///< the owner's avatar touches it, directly or through other bodies
  bool awake = false;          ///< it moves, in its owner's world
};

/// Which of two claims to `body` counts: the one with the higher sequence number, of equal ones that with the smaller
/// hash of (peer, body, sequence), which favours nobody. Peers agree whatever order claims arrive in.
bool beats(const Claim& a, const Claim& b, EntityId body);

/// The authority that all alternatives share, so that none has a better rule than another or than ours: authority is
/// taken by contact, at once and without asking, and travels with the state, with a sequence number for each claim as
/// in Fiedler's "Networked Physics in Virtual Reality". A peer claims a body
///   - that its avatar touches, directly or through bodies of its own, unless its owner's avatar holds it;
///   - that a moving body of its own touches, if it is at rest in its owner's world ("if you throw a cube into a
///     stack, you take the stack").
/// It stays the owner until somebody else claims the body: as nothing is sent of what rests, that costs nothing.
class ClaimTable {
 public:
  ClaimTable(PeerId self, int bodies) : self_(self), claims_(static_cast<std::size_t>(bodies)) {}

  const Claim& of(EntityId body) const { return claims_[body]; }
  bool mine(EntityId body) const { return claims_[body].owner == self_; }
  /// A peer says that it owns the body. False if somebody else's claim beats that: what it says does not count.
  bool hear(EntityId body, const Claim& told);
  /// Looks at the contacts of the last step in this peer's own world, in which its avatar is `avatar`.
  void touch(const world::World& world, EntityId avatar);

 private:
  void take(EntityId body);
  void reach(const world::World& world, std::vector<EntityId> frontier, bool by_avatar);

  PeerId self_;
  std::vector<Claim> claims_;
  std::vector<char> reached_;
};

}  // namespace padr::lab::alternatives
