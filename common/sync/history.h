#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/sync/fold.h"

namespace padr::sync {

/// The states of the agreed world at the begin of the latest ticks, before their updates. Those that are no longer
/// needed make room for the next ones at once: what is written and read again and again is then no more than what is
/// needed, and stays near the processor, however much may be kept if it has to be.
class History {
 public:
  /// At most the states of so many ticks, 0 for none; empties it.
  void resize(std::size_t ticks);
  bool empty() const { return at_.empty(); }
  bool has(Tick t) const { return !at_.empty() && t >= 0 && holds(t); }
  /// The place of tick t's state, with what was in it before: that state if it is there, or else an older one, of which
  /// nothing is there then. Not to be called of an empty history.
  FoldState& place(Tick t);
  /// The state of a tick that it has.
  FoldState& at(Tick t);
  const FoldState& at(Tick t) const;
  /// Memory for so many states from the start, or for as many as may be kept, each with room for what is in the one
  /// that is there.
  void reserve(std::size_t states);
  /// The states of the ticks below this one are not needed any more.
  void forget_before(Tick t);

 private:
  std::size_t index(Tick t) const { return static_cast<std::size_t>(t) % at_.size(); }
  bool holds(Tick t) const;
  void make_more(std::size_t more);

  std::vector<FoldState*> at_;  ///< by tick, round and round; null: none
  std::vector<std::unique_ptr<FoldState>> states_;
  std::vector<FoldState*> free_;  ///< the one used last at the end
  Tick oldest_ = 0;               ///< there may be states from here on
};

}  // namespace padr::sync
