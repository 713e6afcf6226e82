#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/sync/authority.h"
#include "common/sync/avatar_model.h"
#include "common/sync/residents.h"
#include "common/sync/updates.h"
#include "common/world/world.h"

namespace padr::sync {

/// Who sits in a slot.
struct Member {
  bool present = false;
  std::uint32_t incarnation = 0;  ///< which of those who have sat there in turn
  bool going = false;             ///< of a region of a crowd: wants to leave once that leaves it in good hands
  friend bool operator==(const Member&, const Member&) = default;
};

/// When play begins: until then time passes and members come in, but nothing moves.
struct Start {
  int wanted = 0;  ///< avatars that play waits for; 0: for nobody any more
  Tick at = 0;     ///< once nobody is waited for: play begins at this tick
  bool reached(Tick now) const { return wanted == 0 && now >= at; }
  friend bool operator==(const Start&, const Start&) = default;
};
/// Ticks from the admission of the last player waited for to the begin of play: time for it to reach everybody.
inline constexpr Tick kStartLead = kTicksPerSecond;

/// The agreed world at the begin of one tick, before that tick's updates.
struct FoldState {
  Tick tick = 0;
  Start start;
  world::Snapshot world;
  std::vector<Member> members;       ///< by peer
  std::vector<AvatarModel> avatars;  ///< by peer
  std::vector<Authority> authority;  ///< by body
  std::vector<PeerSet> holds;        ///< by body: whose avatars hold it
  Residents residents;               ///< of a region of a crowd
  bool playing() const { return start.reached(tick); }
  /// Whether p is a member without an avatar, in a session that is no region of a crowd.
  bool spectates(PeerId p) const { return members[p].present && !avatars[p].present; }
};

/// The deterministic fold of a log of updates: bodies play out by physics, avatars follow their models, a modelled
/// avatar touches only what it is known to hold, and an update overwrites the state of its entities at its tick.
/// Fed the same bundles in the same order at the same ticks, every Fold of a scene is the same to the bit.
class Fold {
 public:
  /// The avatars of peers 0 .. peers-1 are there from tick 0, at rest at their spawn points; `slots` >= peers is how
  /// many there may ever be. `authority` false: no holds, no owners; avatars collide with every body (the paper's
  /// failure case). `wanted`: avatars that play waits for; 0: it begins at tick 0.
  Fold(const Scene& scene, int slots, int peers, bool authority, int wanted = 0);

  Tick tick() const { return tick_; }
  const world::World& world() const { return world_; }
  const std::vector<AvatarModel>& avatars() const { return avatars_; }
  const std::vector<Authority>& authority() const { return authority_; }
  const std::vector<PeerSet>& holds() const { return holds_; }
  /// Whether peer p's avatar holds the body.
  bool holds(PeerId p, EntityId body) const { return (holds_[body] & only(p)) != 0; }

  const std::vector<Member>& members() const { return members_; }
  const Residents& residents() const { return residents_; }

  /// Overwrites with what the bundle says, as of now, whatever tick it bears; nothing if its peer is no member.
  /// What it says of a body is refused if that authority has been superseded.
  void apply(const Bundle& bundle) { apply(bundle, bundle.tick); }
  /// The same for an update of the tick `told` that counts as one of another tick.
  void apply(const Bundle& bundle, Tick told);
  /// Advances one tick. Before play begins nothing moves.
  void step();

  void set_start(const Start& start) { start_ = start; }
  /// See Fault in agreed_world.h.
  void disturb(EntityId e, Vec2 by);

  void save(FoldState& out) const;
  void restore(const FoldState& s);
  /// Only these entities have another state; `keep`: by entity id, set for all others.
  void restore_only(const FoldState& s, const std::vector<EntityId>& which, const std::vector<bool>& keep);

  // A fold of some of the entities: the others are not there, and nothing of what is told of their states is done. Who
  // owns and holds what is folded in full.

  /// Leaves out the entities whose bit is set, by entity id; `in`: the others.
  void leave_out(const std::vector<EntityId>& in, const std::vector<bool>& out);
  /// As `leave_out`, then takes over the state of the rest.
  void restore_part(const FoldState& s, const std::vector<EntityId>& in, const std::vector<bool>& out);
  bool with_authority() const { return with_authority_; }
  /// Whether there is anything in this slot.
  bool is_there(EntityId e) const;

 private:
  void apply_avatar(PeerId p, const AvatarUpdate& u, Tick tick);
  void apply_body(PeerId p, const BodyUpdate& u, Tick told);
  void admit(const Admission& a, Tick tick);
  void remove(PeerId p);
  void remove_avatar(PeerId p);
  void pass(PeerId p, const Passage& passage, Tick tick);
  void leave_free(EntityId body);
  void set_hold(PeerId p, EntityId body, bool held);
  void take_tables(const FoldState& s);
  bool plays(EntityId e) const { return left_out_.empty() || !left_out_[e]; }

  world::World world_;
  bool with_authority_;
  Tick tick_ = 0;
  Start start_;
  std::vector<Member> members_;
  std::vector<AvatarModel> avatars_;
  std::vector<Authority> authority_;
  std::vector<PeerSet> holds_;
  std::vector<bool> left_out_;  ///< by entity; empty: none
  std::vector<EntityId> played_;
  Residents residents_;
};

}  // namespace padr::sync
