#pragma once

#include <vector>

#include "common/model/state.h"

namespace padr::sync {

/// What changed in the chain of contacts avatar -> body -> body -> ... since the last tick; each list ascending.
struct ChainChanges {
  std::vector<EntityId> begun;   ///< bodies that the avatar itself began to touch
  std::vector<EntityId> ended;   ///< bodies that it no longer touches
  std::vector<EntityId> joined;  ///< bodies that entered the chain by proxy
  std::vector<EntityId> left;    ///< bodies that are no longer in it
};

/// The record of collisions by proxy (paper, section III.c): which bodies the avatar touches, directly
/// or through others. Box2D's contacts flicker while something is pushed, so a link counts as ended only after it has
/// been open for `patience` ticks.
class ContactChain {
 public:
  ContactChain(int bodies, EntityId avatar, Tick patience);
  void retune(Tick patience) { patience_ = patience; }

  /// `contacts`: all touching entities of the tick, sorted. What it gives is good until the next call.
  const ChainChanges& update(const std::vector<Contact>& contacts, Tick now);

  bool held(EntityId body) const { return direct_[body] != kNever; }
  bool touching_now(EntityId body, Tick now) const { return direct_[body] == now; }
  bool member(EntityId body) const { return chain_[body] != kNever; }
  /// Bodies that are held or members, ascending.
  const std::vector<EntityId>& linked() const { return linked_; }

 private:
  static constexpr Tick kNever = -1;

  EntityId avatar_;
  Tick patience_;
  std::vector<Tick> direct_;  ///< by body: last tick the avatar touched it, while held
  std::vector<Tick> chain_;   ///< by body: last tick it was in the chain, while a member
  std::vector<char> reached_;
  std::vector<EntityId> linked_;
  std::vector<EntityId> looked_at_;
  ChainChanges changes_;
};

/// Marks the bodies that can be reached through contacts from any that is marked, and adds them to `found`; `marked` is
/// by entity id. Avatars that are not marked end a path: their own peers report them.
void reach(const std::vector<Contact>& contacts, int bodies, std::vector<char>& marked, std::vector<EntityId>& found);

}  // namespace padr::sync
