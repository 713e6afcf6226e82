#pragma once

#include <cstddef>
#include <vector>

#include "common/sync/fold.h"

namespace padr::sync {

/// The states of the agreed world at the begin of the latest ticks, before their updates.
class History {
 public:
  /// `ticks` of them, 0 for none; empties it.
  void resize(std::size_t ticks) {
    ring_.resize(ticks);
    for (FoldState& s : ring_) s.tick = -1;
  }
  bool empty() const { return ring_.empty(); }
  /// The place of tick t's state: that state, or a much older one. Not to be called of an empty history.
  FoldState& at(Tick t) { return ring_[static_cast<std::size_t>(t) % ring_.size()]; }
  const FoldState& at(Tick t) const { return ring_[static_cast<std::size_t>(t) % ring_.size()]; }
  bool has(Tick t) const { return !ring_.empty() && t >= 0 && at(t).tick == t; }

 private:
  std::vector<FoldState> ring_;
};

}  // namespace padr::sync
