#pragma once

#include <cstdint>
#include <functional>

#include "common/sync/fold.h"
#include "common/sync/replay_budget.h"
#include "common/sync/update_log.h"

namespace padr::sync {

/// For tests only: something that must never happen. At `tick`, and whenever that tick is folded again, `entity` is
/// found `by` metres from where it is.
struct Fault {
  Tick tick = -1;
  EntityId entity = 0;
  Vec2 by;
};

struct AgreedConfig {
  int slots = 0;  ///< avatar slots of the session
  int peers = 0;  ///< at tick 0: 0 .. peers-1; unused when beginning later
  PeerId self = 0;
  bool authority = true;
  bool replay = true;
  Fault fault;
  /// States of so many past ticks are kept for rewinding: 8.5 s, well past any delay of a link that is worth playing
  /// over. Older updates are served by folding anew from confirmed, which costs more and loses nothing.
  std::size_t kept_ticks = 512;
  /// How much may be replayed in a tick at once, in steps of one body: about 3 ms. What is left is done in the next
  /// ticks.
  std::size_t replay_budget = 10'000;
  bool time_stamps = false;  ///< see Technique
  int wanted = 0;            ///< avatars that play waits for, from tick 0 on; unused when beginning later
};

/// What a timeline works on: the agreed world's, which outlives it.
struct TimelineParts {
  const AgreedConfig& config;
  const UpdateLog& log;
  Fold& predicted;
  FoldState& confirmed;
  ReplayBudget& budget;
  std::uint64_t& replayed_steps;  ///< counted on
  /// The newest tick whose state rests on updates that are all in the log.
  std::function<Tick()> complete;
  /// Called with every state that becomes confirmed, in order.
  std::function<void(const FoldState&)> announce;
};

/// How predicted gets on, and confirmed after it: one of two ways, which a session may change between while it runs.
class Timeline {
 public:
  virtual ~Timeline() = default;

  /// The log has one more update.
  virtual void file(const Bundle& bundle) = 0;
  /// Updates of the slot numbered `from` and up are not in the log any more, the first of them of tick `earliest`.
  virtual void undo(PeerId peer, std::uint32_t from, Tick earliest) = 0;
  /// Brings predicted up to date with the log, as far as the budget goes; false if it stays as it was.
  virtual bool catch_up() = 0;
  /// The same without a budget.
  virtual void finish() = 0;
  /// Advances predicted by one tick. Call `look` when nothing more happens to it.
  virtual void step() = 0;
  /// Notes predicted as it is now for predicted_state.
  virtual void look() = 0;
  /// Advances confirmed, up to this tick at most.
  virtual void confirm(Tick complete) = 0;

  virtual const FoldState& predicted_state() const = 0;
  /// The confirmed state of a tick, while it is kept; null otherwise.
  virtual const FoldState* confirmed_at(Tick t) const = 0;
  /// A replay has been left for the ticks to come.
  virtual bool replaying() const = 0;
  virtual std::uint64_t locally_replayed_steps() const = 0;
};

/// As many contacts as there once were may be there again: every state that is kept has room for them at once, not when
/// its turn comes.
class SnapshotRoom {
 public:
  explicit SnapshotRoom(const world::World& world) : most_contacts_(world.usual_contacts()) {}
  void make(world::Snapshot& s) const;
  void save(const Fold& fold, FoldState& out);

 private:
  std::size_t most_parted_ = 16;
  std::size_t most_contacts_;
};

}  // namespace padr::sync
