#pragma once

#include "common/sync/arrivals.h"
#include "common/sync/timeline.h"

namespace padr::sync {

/// Without replay, our reading of the paper: updates are applied to predicted when they arrive, as if true now.
/// Confirmed is a second world that follows behind.
class ArrivalTimeline final : public Timeline {
 public:
  /// Goes on with predicted as it is: updates that are in it count as having arrived, those of ticks to come arrive
  /// now.
  explicit ArrivalTimeline(const TimelineParts& parts);

  void file(const Bundle& bundle) override { arrivals_.add(bundle); }
  void undo(PeerId peer, std::uint32_t from, Tick) override { arrivals_.take_back(peer, from); }
  bool catch_up() override;
  void finish() override;
  void step() override { parts_.predicted.step(); }
  void look() override { room_.save(parts_.predicted, now_); }
  void confirm(Tick complete) override;
  const FoldState& predicted_state() const override { return now_; }
  const FoldState* confirmed_at(Tick) const override { return nullptr; }
  bool replaying() const override { return false; }
  std::uint64_t locally_replayed_steps() const override { return 0; }

 private:
  TimelineParts parts_;
  Arrivals arrivals_;
  Fold follower_;  ///< where confirmed is
  SnapshotRoom room_;
  FoldState now_;  ///< predicted
};

}  // namespace padr::sync
