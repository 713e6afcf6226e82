#pragma once

#include "common/replica/replica.h"

namespace padr::peer {

/// Somebody who looks on while a Player plays. Must be quick, and must not change anything.
class Watcher {
 public:
  struct Step {
    const node::Replica& replica;  ///< after the step
    Vec2 target;                   ///< m, that it was driven towards
    bool driven;                   ///< by an order, not by its own input
    Micros lateness;               ///< of the step's begin, us
  };

  Watcher() = default;
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;
  virtual ~Watcher() = default;

  /// An incarnation begins to play, counted from 0.
  virtual void begun(const node::Replica& replica, int incarnation) = 0;
  virtual void stepped(const Step& step) = 0;
  /// As of node::ParticipantConfig: also of an incarnation that is only being begun.
  virtual void confirmed(int incarnation, const sync::FoldState& state, std::uint64_t hash) = 0;
  virtual void changed(const node::MemberChange& change) = 0;
};

}  // namespace padr::peer
