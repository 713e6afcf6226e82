#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/sync/fold.h"
#include "common/sync/state_hash.h"
#include "common/sync/timeline.h"
#include "common/sync/transfer.h"
#include "common/sync/update_log.h"

namespace padr::sync {

/// The two views of the agreed world that a peer keeps.
///
/// *Predicted* is the fold up to now with every update known so far: how an update that arrives late gets into it, its
/// timeline decides.
///
/// *Confirmed* is the fold up to the newest tick for which everybody's updates are complete; it never goes back and is
/// the same on every peer.
class AgreedWorld {
 public:
  /// Called once for every tick that becomes confirmed, in order, beginning with tick 0.
  using ConfirmedSink = std::function<void(const FoldState&, const LazyHash& hash)>;

  /// From tick 0 on.
  AgreedWorld(const Scene& scene, const AgreedConfig& config, ConfirmedSink on_confirmed);
  /// From where another one is, the tail not filed yet, and not yet a part of it.
  AgreedWorld(const Scene& scene, const AgreedConfig& config, const Transfer& start, ConfirmedSink on_confirmed);

  ~AgreedWorld();
  // Its timeline refers to it.
  AgreedWorld(const AgreedWorld&) = delete;
  AgreedWorld& operator=(const AgreedWorld&) = delete;

  /// Files an update, own or foreign; false if it was known. Foreign ones take effect in the next catch_up.
  bool insert(const Bundle& bundle);
  const UpdateLog& log() const { return log_; }
  /// As in UpdateLog.
  void mark(PeerId peer, Tick tick, std::uint32_t count) { log_.mark(peer, tick, count); }
  void forget_promises(PeerId peer) { log_.forget_promises(peer); }
  void close(PeerId peer, std::uint32_t count);
  std::vector<Bundle> hold(PeerId peer);
  void open(PeerId peer, Tick since) { log_.open(peer, since); }
  /// As open, of the own slot.
  void enter(Tick since);
  /// Confirmed updates of ticks from `tick` on are kept, for those who may lack them.
  void keep_from(Tick tick) { keep_ = tick; }

  /// Rewinds and replays from now on, or no longer. Predicted may become another: the caller takes it over. Confirmed
  /// stays what it is.
  void set_replay(bool on);
  /// From the next update that arrives on.
  void set_time_stamps(bool on) { config_.time_stamps = on; }

  /// Brings predicted up to date with all that has been filed, as far as this tick's budget goes; false if it stays as
  /// it was.
  bool catch_up() { return timeline_->catch_up(); }
  /// Advances predicted by one tick.
  void step();
  /// Advances confirmed as far as the log is complete and has been replayed; own updates are complete up to the present
  /// tick.
  void confirm();

  Tick now() const { return predicted_.tick(); }
  const Fold& predicted() const { return predicted_; }
  /// Predicted as of now, with the updates of this tick.
  const FoldState& predicted_state() const { return timeline_->predicted_state(); }
  const FoldState& confirmed() const { return confirmed_; }
  /// The confirmed state of a tick, while it is kept; null otherwise, and always without replay.
  const FoldState* confirmed_at(Tick t) const { return timeline_->confirmed_at(t); }
  std::uint64_t confirmed_hash() const { return hash_of(confirmed_); }

  /// Steps made again for updates that came late.
  std::uint64_t replayed_steps() const { return replayed_steps_ + locally_replayed_steps(); }
  /// A replay has been left for the ticks to come.
  bool replaying() const { return timeline_->replaying(); }
  /// Of the replayed ones, steps of only what such an update had to do with.
  std::uint64_t locally_replayed_steps() const { return timeline_->locally_replayed_steps(); }

 private:
  void begin();
  TimelineParts parts();
  /// The newest tick whose state rests on updates that are all in the log.
  Tick complete() const;
  void announce(const FoldState& s);

  AgreedConfig config_;
  ConfirmedSink on_confirmed_;
  StateHasher hasher_;
  UpdateLog log_;
  Fold predicted_;
  FoldState confirmed_;
  ReplayBudget budget_;  ///< for all that is done from one confirm to the next
  std::uint64_t replayed_steps_ = 0;
  std::unique_ptr<Timeline> timeline_;  ///< with replay or without
  Tick keep_ = 0;
  bool in_ = true;  ///< the own slot's updates are this peer's
};

}  // namespace padr::sync
