#pragma once

#include <cstdint>
#include <vector>

#include "common/sync/fold.h"

namespace padr::sync {

/// Without replay, our reading of the paper: updates are applied when they arrive, as if true now, but never an older
/// word on an entity after a newer one of the same peer.
///
/// With time stamps (DIS practice) an update is moved on by its age first: an avatar as its model has it, a body by its
/// velocity and spin. Nothing stands in the way of either.
class Arrivals {
 public:
  Arrivals(int slots, int bodies);

  void add(const Bundle& b) { waiting_.push_back(b); }
  bool any() const { return !waiting_.empty(); }
  /// Updates of the slot numbered `from` and up have not come after all.
  void take_back(PeerId peer, std::uint32_t from);
  /// This one has been applied at its own tick.
  void note(Bundle b) { keep_newest(b); }
  /// Applies all that has been added.
  void apply_to(Fold& fold, bool time_stamps);

 private:
  void keep_newest(Bundle& b);

  std::vector<Bundle> waiting_;
  std::vector<std::uint32_t> first_;            ///< by peer: what is numbered lower is of a former occupant of its slot
  std::vector<Tick> newest_avatar_;             ///< by peer
  std::vector<std::vector<Tick>> newest_body_;  ///< by peer, then body
};

}  // namespace padr::sync
