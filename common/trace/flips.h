#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/model/ids.h"

namespace padr::trace {

/// How often authority over one body, or over all of them, passed from one peer straight to another.
struct HandOvers {
  std::uint64_t takeovers = 0;  ///< all of them
  std::uint64_t flips = 0;  ///< those among them that took the body from a peer that had hardly got it: see FlipMeter
  friend bool operator==(const HandOvers&, const HandOvers&) = default;
};

/// Flips of authority, as a fold over the owners of bodies in confirmed worlds.
///
/// A *takeover*: at one confirmed tick a body is peer A's, at the next it is peer B's. Nobody let go of it: a body that
/// has come to rest is released first, and one whose owner has left is too; to claim such a body takes it from nobody.
/// A *flip*: a takeover less than kFlipTicks after the body came to be A's. That is what ping-pong is made of; a ball
/// that is passed on every few seconds changes hands without one.
class FlipMeter {
 public:
  static constexpr Tick kFlipTicks = kTicksPerSecond;

  explicit FlipMeter(int bodies);

  /// Who owns what at the next confirmed tick, by entity id, kNoPeer for nobody; what is beyond the bodies is not
  /// looked at. Ticks are given in order; what is not given counts as unchanged.
  void owners(Tick tick, const std::vector<PeerId>& owner);

  const HandOvers& all() const { return all_; }
  /// Only bodies that changed hands.
  const std::map<EntityId, HandOvers>& by_body() const { return by_body_; }

 private:
  struct Held {
    PeerId owner = kNoPeer;
    Tick since = 0;
  };
  std::vector<Held> held_;  ///< by body
  HandOvers all_;
  std::map<EntityId, HandOvers> by_body_;
};

}  // namespace padr::trace
