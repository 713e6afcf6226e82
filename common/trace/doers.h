#pragma once

#include <cstddef>
#include <vector>

#include "common/model/ids.h"
#include "common/model/state.h"

namespace padr::trace {

/// Which players have had to do with which bodies lately. A player has to do with a body whose contact with its avatar
/// is seen, and with every body that is reached from there through contacts. A body that moves stays with whoever had
/// to do with it last.
class Doers {
 public:
  /// Two players who have had to do with a body within this of one another share it.
  static constexpr Tick kTogether = kTicksPerSecond;
  /// A body at rest stays this long with the last player who had to do with it: time enough for others to learn of it.
  static constexpr Tick kAfter = 2 * kTicksPerSecond;
  /// A body is in motion above this, m/s.
  static constexpr float kMoving = 0.05F;

  static constexpr int kNobody = -1;
  static constexpr int kSeveral = -2;

  /// Doers are 0 .. doers-1.
  Doers(std::size_t bodies, std::size_t doers);

  void touched(EntityId body, std::size_t doer, Tick now) { note(body, doer, now); }
  /// Whoever has to do with one end of a contact between bodies has to do with the other.
  void spread(const std::vector<Contact>& contacts, Tick now);
  /// The doer of a body with whom a body in motion stays; kNobody: it is at rest long since, or nobody's.
  int last(EntityId body, Tick now) const;

  /// Settles the question of `of` for a tick.
  void judge(Tick now);
  /// Whose the body is: a doer, kNobody or kSeveral. As of the last judge.
  int of(EntityId body) const { return of_[body]; }

 private:
  static constexpr Tick kNever = -1'000'000;
  Tick& stamp(EntityId body, std::size_t doer) { return stamps_[body * doers_ + doer]; }
  Tick stamp(EntityId body, std::size_t doer) const { return stamps_[body * doers_ + doer]; }
  void note(EntityId body, std::size_t doer, Tick when);
  bool join(EntityId a, EntityId b, Tick now);

  std::size_t doers_;
  std::vector<Tick> stamps_;  ///< by body, then doer: when it last had to do with it
  std::vector<Tick> newest_;  ///< by body, of its stamps
  std::vector<int> of_;       ///< by body
};

}  // namespace padr::trace
