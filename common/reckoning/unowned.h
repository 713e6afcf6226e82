#pragma once

#include <vector>

#include "common/sync/fold.h"
#include "common/world/view.h"

namespace padr::sync {

/// With Unowned::kLive: which bodies that nobody owns stay as the live world has them.
///
/// All that differ from the predicted world do. The exception is a body of which somebody else has just said something
/// that counts: its authority record has changed by another peer's word since the last call, and nobody owns it now.
/// Its predicted state is taken over once; from then on it plays out in the live world again. The predicted world moves
/// by what others tell and by how their avatars are modelled, so without that exception a player would never see where
/// another one has left a body, and without the rule it would adopt what a wrong model did to a body that nobody
/// touched.
class UnownedBodies {
 public:
  /// Both of the same tick. Ascending, good until the next call.
  const std::vector<EntityId>& kept(const FoldState& predicted, const world::View& live, PeerId self);
  /// Nothing is kept until the next call of `kept`, nor by that one.
  void reset() {
    seen_.clear();
    kept_.clear();
  }
  /// As of the last call of `kept`.
  const std::vector<EntityId>& kept() const { return kept_; }

 private:
  std::vector<Authority> seen_;  ///< by body, as of the last call; empty: there was none
  std::vector<EntityId> kept_;
};

}  // namespace padr::sync
