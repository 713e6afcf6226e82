#pragma once

#include <cstdint>
#include <vector>

#include "common/sync/history.h"
#include "common/sync/update_log.h"
#include "common/world/bounding_radius.h"

namespace padr::sync {

/// Replays only what a late update has to do with, where that gives the same bits as replaying everything.
///
/// Box2D solves what touches together, and apart from everything else. So the entities that a late update tells of,
/// those that they had to do with since, those that these had to do with and so on, can be played anew in a world of
/// their own, as long as none of them comes near an entity that is not among them; the rest of the history stands. Who
/// had to do with whom is in the history: contacts, and those that parted in the very step in which they touched.
/// Wherever it cannot be sure, it gives up, and all has to be replayed.
class LocalReplay {
 public:
  LocalReplay(const Scene& scene, int slots, bool authority);

  /// This update has come late.
  void concerns(const Bundle& b);
  /// More has changed than what updates tell of bodies and avatars.
  void concerns_all() { all_ = true; }
  /// Nothing is late any more.
  void clear();

  /// Makes the history of the ticks from+1 .. now what it is with all that the log has, given that nothing but what has
  /// been told with `concerns` has changed in it, all of it from tick `from` on. False: it gives up, as it does if it
  /// would take more than `most` steps of one entity; then the history beyond `from` is not to be used.
  bool run(History& history, const UpdateLog& log, Tick from, Tick now, std::size_t most);
  /// After run: what it has left of `most`.
  std::size_t left() const { return left_; }
  /// After run: those that may have changed; and by entity id, false for them.
  const std::vector<EntityId>& changed() const { return concerned_; }
  const std::vector<bool>& unchanged() const { return left_out_; }
  /// Ticks stepped so far.
  std::uint64_t steps() const { return steps_; }

 private:
  bool take(EntityId e);
  bool gather(const History& history, const UpdateLog& log, Tick from, Tick now);
  bool may_touch(EntityId a, EntityId b) const;
  bool play(History& history, const UpdateLog& log, Tick from, Tick now);
  bool meets_others(const FoldState& others, const std::vector<Bundle>& told);
  bool meets(EntityId other, Vec2 there) const;
  bool merge(FoldState& into);
  void spend(std::size_t steps);

  Fold fold_;
  bool never_;                       ///< the scene is not one for this
  std::vector<float> reach_;         ///< by entity, m: nothing of it is farther from its centre
  std::vector<EntityId> concerned_;  ///< in the order in which they were found
  world::BoundingBox box_;           ///< around them, where they are in fold_
  std::vector<bool> left_out_;       ///< by entity: not concerned
  bool all_ = false;
  Tick latest_ = -1;      ///< of the updates that have come late
  std::size_t left_ = 0;  ///< of what run may do, in steps of one entity
  world::Snapshot mine_;
  std::vector<world::ContactState> contacts_;
  std::uint64_t steps_ = 0;
};

}  // namespace padr::sync
