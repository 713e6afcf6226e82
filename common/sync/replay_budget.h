#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

#include "common/sync/fold.h"

namespace padr::sync {

/// How much may be replayed in a tick at once, in steps of one body. What is left is done in the next ticks.
class ReplayBudget {
 public:
  explicit ReplayBudget(std::size_t of_a_tick) : of_a_tick_(of_a_tick) {}

  /// It is given to this tick.
  void begin(Tick tick) {
    begun_ = tick;
    left_ = of_a_tick_;
    least_ = kLeastSteps;
  }
  Tick begun() const { return begun_; }
  /// No end of it in this tick.
  void lift() { left_ = std::numeric_limits<std::size_t>::max(); }

  bool bears(Tick steps, const Fold& fold) const {
    return steps <= kLeastSteps || static_cast<std::size_t>(steps) * cost_of(fold) <= left_;
  }
  /// To be asked before each step that may as well be made later.
  bool may_step() { return left_ > 0 || least_-- > 0; }
  /// The fold has made one.
  void spend_step(const Fold& fold) { left_ -= std::min(left_, cost_of(fold)); }
  std::size_t left() const { return left_; }
  void leave(std::size_t left) { left_ = left; }

 private:
  /// What a step costs however little there is to it.
  static constexpr std::size_t kLeastCost = 16;
  /// So many steps are made in a tick whatever they cost: more than one, or a replay would never catch up, and enough
  /// to have done with what comes late at every tick by the delay of a link.
  static constexpr int kLeastSteps = 4;

  static std::size_t cost_of(const Fold& fold) { return std::max(kLeastCost, fold.world().listed()); }

  std::size_t of_a_tick_;
  Tick begun_ = 0;
  std::size_t left_ = 0;
  int least_ = 0;  ///< steps that this tick may make beyond it
};

}  // namespace padr::sync
