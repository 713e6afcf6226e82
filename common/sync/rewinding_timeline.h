#pragma once

#include <memory>

#include "common/sync/history.h"
#include "common/sync/local_replay.h"
#include "common/sync/timeline.h"

namespace padr::sync {

/// With replay: an update that arrives late rewinds predicted to the tick it belongs to and replays. Since a step
/// depends on nothing but the state that is kept of every tick, what comes out is what would have come out had the
/// update never been late. A replay that is too long for one tick goes on behind predicted, which knows nothing of what
/// is late until it has been caught up with. Where only few bodies are concerned, only those are stepped again.
///
/// Confirmed is the state kept of a tick, which is final from then on. If it lags by more than is kept, it is a second
/// world that follows behind.
class RewindingTimeline final : public Timeline {
 public:
  /// Goes on from confirmed. If predicted is further on already, `replay_all` comes next.
  explicit RewindingTimeline(const TimelineParts& parts);
  /// Makes predicted again from confirmed on.
  void replay_all() { rewind_to(parts_.confirmed.tick); }

  void file(const Bundle& bundle) override;
  void undo(PeerId peer, std::uint32_t from, Tick earliest) override;
  bool catch_up() override;
  void finish() override;
  void step() override { advance_predicted(); }
  void look() override;
  void confirm(Tick complete) override;
  const FoldState& predicted_state() const override { return in_history_ ? history_.at(now()) : current_; }
  const FoldState* confirmed_at(Tick t) const override;
  bool replaying() const override { return behind_; }
  std::uint64_t locally_replayed_steps() const override { return local_.steps(); }

 private:
  Tick now() const { return parts_.predicted.tick(); }
  bool comes_next(const Bundle& bundle) const;
  /// Updates of the tick at which it is.
  void apply_known(Fold& fold) const;
  void advance_predicted();
  void rewind_to(Tick t);
  bool replay();
  bool replay_locally();
  void fall_behind();
  bool catch_up_behind();
  void step_behind();
  bool is_too_long() const;
  void settle();
  /// Updates of this tick have changed. Returns whether something has been folded with them already.
  bool note_late(Tick t);
  /// The newest tick whose kept state is what the log says.
  Tick replayed_to() const;
  void confirm_from_kept(Tick upto);
  void confirm_by_folding(Tick upto);
  Fold& follower();

  TimelineParts parts_;
  SnapshotRoom room_;
  FoldState current_;  ///< predicted as of now, if it is not in the history
  bool in_history_ = false;
  History history_;  ///< of predicted
  LocalReplay local_;
  Tick dirty_;                      ///< earliest tick whose updates have changed since predicted was computed
  bool told_now_ = false;           ///< predicted has updates of this tick that the state as of now has not
  std::unique_ptr<Fold> follower_;  ///< of what is too long for a tick; made when it is needed
  bool behind_ = false;             ///< the follower is replaying, to catch up with predicted
  bool follows_confirmed_ = false;  ///< the follower is where confirmed is
};

}  // namespace padr::sync
