#pragma once

#include <span>
#include <vector>

#include "common/model/scene.h"
#include "common/model/state.h"
#include "common/world/world.h"

namespace padr::trace {

/// A copy of one player's live world that is left to itself: stepped with what the player's avatar was really driven
/// by, with no update applied. It says what the player's deeds, and nothing else, do to bodies.
///
/// Other avatars are where the player sees them and touch no body; bodies that are others' are where the player sees
/// them. The copy is taken anew after kHorizon ticks, counted from the avatar's first touch of a body in it: any two
/// runs of physics part sooner or later. Until that touch, the own avatar too is where the player sees it.
class Undisturbed {
 public:
  static constexpr Tick kHorizon = kTicksPerSecond;

  Undisturbed(const Scene& scene, int slots, PeerId self);

  /// Takes the copy. `view`: the live world's states, by entity id.
  void take(std::span<const BodyState> view);
  void drop() { running_ = false; }
  bool running() const { return running_; }
  /// Whether kHorizon is over.
  bool is_due() const { return age_ >= kHorizon; }

  /// Whether an avatar is there. `unseen`: what it does to bodies is known from the player's view only, so it may.
  void set_avatar(PeerId p, bool present, bool unseen);
  /// A tick. `before`: the live world's states before it; `is_others`: by body, whether it is taken from there.
  void step(std::span<const BodyState> before, const std::vector<char>& is_others, Vec2 target);

  /// As of the last step.
  const std::vector<Contact>& contacts() const { return stepped_ ? world_.contacts() : none_; }
  Vec2 position(EntityId e) const { return world_.position(e); }  ///< m
  EntityId avatar() const { return world_.avatar(self_); }
  /// How many copies the avatar has touched a body in.
  std::uint64_t deeds() const { return deeds_; }

 private:
  bool touches() const;
  bool may_anything_happen(std::span<const BodyState> before, const std::vector<char>& is_others) const;
  bool is_near_any(EntityId e, Vec2 at, const std::vector<char>& left_out) const;

  world::World world_;
  PeerId self_;
  std::vector<float> reach_;     ///< by entity, m
  std::vector<char> none_left_;  ///< by body: 0
  std::vector<Contact> none_;
  bool any_unseen_ = false;  ///< avatars
  bool stepped_ = false;     ///< in the last tick
  bool running_ = false;
  bool touched_ = false;  ///< a body, since the copy was taken
  Tick age_ = 0;
  std::uint64_t deeds_ = 0;
};

}  // namespace padr::trace
