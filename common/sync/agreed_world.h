#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/sync/arrivals.h"
#include "common/sync/fold.h"
#include "common/sync/history.h"
#include "common/sync/local_replay.h"
#include "common/sync/replay_budget.h"
#include "common/sync/state_hash.h"
#include "common/sync/transfer.h"
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
};

/// The two views of the agreed world that a peer keeps.
///
/// *Predicted* is the fold up to now with every update known so far. With replay, an update that arrives late rewinds
/// it to the tick it belongs to and replays; since a step depends on nothing but the state that is kept of every tick,
/// what comes out is what would have come out had the update never been late. A replay that is too long for one tick
/// goes on behind predicted, which knows nothing of what is late until it has been caught up with. Without replay (the
/// paper) updates are applied when they arrive, as if true now.
///
/// *Confirmed* is the fold up to the newest tick for which everybody's updates are complete; it never goes back and is
/// the same on every peer. With replay it is not a world of its own but the state kept of that tick, which is final
/// from then on; without replay, or if it lags by more than is kept, it is a second fold that follows behind.
class AgreedWorld {
 public:
  /// Called once for every tick that becomes confirmed, in order, beginning with tick 0.
  using ConfirmedSink = std::function<void(const FoldState&, const LazyHash& hash)>;

  /// From tick 0 on.
  AgreedWorld(const Scene& scene, const AgreedConfig& config, ConfirmedSink on_confirmed);
  /// From where another one is, the tail not filed yet, and not yet a part of it.
  AgreedWorld(const Scene& scene, const AgreedConfig& config, const Transfer& start, ConfirmedSink on_confirmed);

  /// Files an update, own or foreign; false if it was known. Foreign ones take effect in the next catch_up.
  bool insert(const Bundle& bundle);
  const UpdateLog& log() const { return log_; }
  /// As in UpdateLog.
  void mark(PeerId peer, Tick tick, std::uint32_t count) { log_.mark(peer, tick, count); }
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
  bool catch_up();
  /// Advances predicted by one tick.
  void step();
  /// Advances confirmed as far as the log is complete and has been replayed; own updates are complete up to the present
  /// tick.
  void confirm();

  Tick now() const { return predicted_.tick(); }
  const Fold& predicted() const { return predicted_; }
  /// Predicted as of now, with the updates of this tick.
  const FoldState& predicted_state() const { return in_history_ ? history_.at(now()) : current_; }
  const FoldState& confirmed() const { return confirmed_; }
  /// The confirmed state of a tick, while it is kept; null otherwise, and always without replay.
  const FoldState* confirmed_at(Tick t) const;
  std::uint64_t confirmed_hash() const { return hash_of(confirmed_); }

  /// Steps made again for updates that came late.
  std::uint64_t replayed_steps() const { return replayed_steps_ + locally_replayed_steps(); }
  /// A replay has been left for the ticks to come.
  bool replaying() const { return behind_; }
  /// Of the replayed ones, steps of only what such an update had to do with.
  std::uint64_t locally_replayed_steps() const { return local_ ? local_->steps() : 0; }

 private:
  void begin();
  void begin_history();
  void look();
  bool comes_next(const Bundle& bundle) const;
  /// Updates of the slot numbered `from` and up are not in the log any more, the first of them of tick `earliest`.
  void undo(PeerId peer, std::uint32_t from, Tick earliest);
  /// Updates of the tick at which it is.
  void apply_known(Fold& fold) const;
  void advance_predicted();
  void make_room(world::Snapshot& s) const;
  void save_predicted(FoldState& out);
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
  Tick confirmable() const;
  void begin_replay();
  void end_replay();
  void expect_arrivals();
  Tick complete_tick() const;
  void announce(const FoldState& s);
  void confirm_from_kept(Tick upto);
  void confirm_by_folding(Tick upto);
  Fold& follower();

  AgreedConfig config_;
  ConfirmedSink on_confirmed_;
  StateHasher hasher_;
  UpdateLog log_;
  Fold predicted_;
  FoldState current_;  ///< predicted as of now, if it is not in the history
  bool in_history_ = false;
  History history_;                     ///< with replay: of predicted
  std::unique_ptr<LocalReplay> local_;  ///< with replay
  Tick dirty_;                          ///< earliest tick whose updates have changed since predicted was computed
  bool told_now_ = false;               ///< predicted has updates of this tick that the state as of now has not
  std::optional<Arrivals> arrivals_;    ///< without replay
  /// Without replay confirmed's own world; with it the one of what is too long for a tick, made when it is needed.
  std::unique_ptr<Fold> follower_;
  bool behind_ = false;             ///< the follower is replaying, to catch up with predicted
  bool follows_confirmed_ = false;  ///< the follower is where confirmed is
  ReplayBudget budget_;             ///< for all that is done from one confirm to the next
  FoldState confirmed_;
  std::size_t most_parted_ = 16;
  std::size_t most_contacts_ = 0;  ///< that every kept state is to have room for
  std::uint64_t replayed_steps_ = 0;
  Tick keep_ = 0;
  bool in_ = true;  ///< the own slot's updates are this peer's
};

}  // namespace padr::sync
