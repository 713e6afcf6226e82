#pragma once

#include <cstdint>
#include <vector>

class b2Body;
class b2World;

namespace padr::world {

/// Keeps out of Box2D's list of bodies those that sleep out of reach of anything awake: every step passes through that
/// list several times, and would only pass them over. What is in the list is always in the order of its making, so a
/// step comes out as if all were in it.
class BodyList {
 public:
  /// `bodies`: those that may move, in the order of their making. Anything else in the world was made after them.
  void begin(b2World& world, const std::vector<b2Body*>& bodies);
  /// Puts all back, so that the world can be taken down.
  void end();

  /// This one has been woken, by other means than a step.
  void woken(std::size_t slot);
  /// Before a step, when all contacts are known that it will look at: lists what is awake and what that may wake.
  void prepare();
  /// Slots of the bodies that are in the list, ascending.
  const std::vector<std::uint32_t>& listed() const { return listed_; }
  /// Whether it is one of them, or has been woken since.
  bool is_listed(std::size_t slot) const { return is_listed_[slot] != 0; }

 private:
  void mark(std::uint32_t slot);
  void reach_from(std::uint32_t slot);
  void link();

  b2World* world_ = nullptr;
  b2Body* last_fixed_ = nullptr;  ///< the last of those made later, which come first in the list; null: none
  std::vector<b2Body*> bodies_;
  std::vector<std::uint32_t> listed_;
  std::vector<std::uint32_t> woken_;
  std::vector<std::uint32_t> next_;
  std::vector<char> marked_;     ///< by slot
  std::vector<char> is_listed_;  ///< by slot
};

}  // namespace padr::world
