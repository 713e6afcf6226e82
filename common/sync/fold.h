#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/sync/authority.h"
#include "common/sync/avatar_model.h"
#include "common/sync/updates.h"
#include "common/world/world.h"

namespace padr::sync {

/// Who sits in a slot.
struct Member {
  bool present = false;
  std::uint32_t incarnation = 0;  ///< which of those who have sat there in turn
  friend bool operator==(const Member&, const Member&) = default;
};

/// The agreed world at the begin of one tick, before that tick's updates.
struct FoldState {
  Tick tick = 0;
  world::Snapshot world;
  std::vector<Member> members;       ///< by peer
  std::vector<AvatarModel> avatars;  ///< by peer
  std::vector<Authority> authority;  ///< by body
  std::vector<std::uint32_t> holds;  ///< by body: bit p set if the avatar of peer p holds it
};

std::uint64_t hash_of(const FoldState& s);

/// The deterministic fold of a log of updates: bodies play out by physics, avatars follow their models, a modelled
/// avatar touches only what it is known to hold, and an update overwrites the state of its entities at its tick.
/// Fed the same bundles in the same order at the same ticks, every Fold of a scene is the same to the bit.
class Fold {
 public:
  /// The avatars of peers 0 .. peers-1 are there from tick 0, at rest at their spawn points; `slots` >= peers is how
  /// many there may ever be. `authority` false: no holds, no owners; avatars collide with every body (the paper's
  /// failure case).
  Fold(const Scene& scene, int slots, int peers, bool authority);

  Tick tick() const { return tick_; }
  const world::World& world() const { return world_; }
  const std::vector<AvatarModel>& avatars() const { return avatars_; }
  const std::vector<Authority>& authority() const { return authority_; }
  const std::vector<std::uint32_t>& holds() const { return holds_; }
  /// Whether peer p's avatar holds the body.
  bool holds(PeerId p, EntityId body) const { return (holds_[body] & (1U << p)) != 0; }

  const std::vector<Member>& members() const { return members_; }

  /// Overwrites with what the bundle says, as of now, whatever tick it bears; nothing if its peer is no member. Returns
  /// how many of its bodies were refused because their authority has been superseded.
  int apply(const Bundle& bundle);
  /// Advances one tick.
  void step();

  /// See Fault in agreed_world.h.
  void disturb(EntityId e, Vec2 by);

  void save(FoldState& out) const;
  void restore(const FoldState& s);

 private:
  void apply_avatar(PeerId p, const AvatarUpdate& u, Tick tick);
  bool apply_body(PeerId p, const BodyUpdate& u);
  void admit(const Admission& a);
  void remove(PeerId p);
  void set_hold(PeerId p, EntityId body, bool held);

  world::World world_;
  bool with_authority_;
  Tick tick_ = 0;
  std::vector<Member> members_;
  std::vector<AvatarModel> avatars_;
  std::vector<Authority> authority_;
  std::vector<std::uint32_t> holds_;
};

}  // namespace padr::sync
