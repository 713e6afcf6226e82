#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/monitor/steering.h"
#include "common/participant/allowance.h"
#include "common/participant/participant.h"
#include "common/scenarios/input.h"
#include "peer/history.h"
#include "peer/lateness.h"
#include "peer/log.h"
#include "peer/options.h"
#include "peer/recordings.h"
#include "peer/watcher.h"

namespace padr::peer {

/// How the ticks of a run came.
struct TickStats {
  std::uint64_t late = 0;    ///< begun more than a tick after their time
  Lateness lateness;         ///< of all of them
  Micros longest_stall = 0;  ///< us that the live world stood still at most, beyond the tick it always does
  std::uint64_t stalls = 0;  ///< times that it did so for more than kStall
  static constexpr Micros kStall = 2 * kMicrosPerSecond / kTicksPerSecond;
};

/// What nodes have counted, in all incarnations.
struct Totals {
  node::ReplicaStats replica;
  std::uint64_t replayed_steps = 0;
  std::uint64_t ticks = 0;  ///< played
};

/// Time that a player stands still by order, and what comes in meanwhile: as with a stopped process, datagrams wait for
/// it as far as there is room, as they would in the system's buffer.
struct Standstill {
  struct Datagram {
    Endpoint from;
    std::vector<std::byte> bytes;
  };
  static constexpr std::size_t kRoom = 2048;
  Micros until = -1;  ///< -1: it does not stand still
  std::vector<Datagram> waiting;
};

/// One peer's play from its coming to its end, whatever incarnations it takes: the participant, its input, its traces
/// and what people want to know of it. Has no clock: times are local microseconds.
class Player {
 public:
  /// All but `session` and `channels` must outlive it; `channels` is there if the session has a key. `watcher` may be
  /// null.
  Player(const Options& options, const node::SessionConfig& session, std::optional<node::ChannelConfig> channels,
         Log& log, Recordings& recordings, Watcher* watcher, Micros now);

  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now);
  /// As in node::Participant.
  void unreachable(const Endpoint& at, Micros now) {
    if (!paused()) participant_.unreachable(at, now);
  }
  /// Does what is due, a bounded number of ticks at most.
  void advance(Micros now);
  /// When to call it next.
  Micros next_due() const;
  /// As in Participant. State datagrams are of the present incarnation.
  std::span<const node::Parcel> take_outgoing() { return participant_.take_outgoing(); }

  /// Says goodbye with the next step, or a few ticks later where many play. `stay`: also help the others to their end.
  /// Only when playing.
  void leave(const std::string& why, bool stay, Micros now);
  /// Gives up coming in. Only before playing.
  void give_up(Micros now) { participant_.leave(now); }
  bool leaving() const { return participant_.leaving(); }
  /// Nothing is left to do, or the time for it is over.
  bool done(Micros now) const { return participant_.done(now); }
  /// Ends the trace. Nothing may be called afterwards but the getters.
  void finish() { participant_.finish(); }

  // What may be ordered while it plays.

  void drive(const monitor::Drive& drive, Micros now) { steering_.take(drive, now); }
  /// Plays by other knobs from the next step on; `authority` must stay.
  void retune(const Technique& technique);
  const Technique& technique() const { return technique_; }
  /// Stands still until then, or goes on at once if that is now.
  void pause(Micros until, Micros now);
  bool paused() const { return still_.until >= 0; }
  /// As in node::Replica.
  void push(EntityId b, Vec2 velocity) { participant_.push(b, velocity); }
  /// Into the trace, for people.
  void remark(const trace::Remark& r) { participant_.remark(r); }

  bool playing() const { return participant_.playing(); }
  bool failed() const { return participant_.failed(); }
  const node::Session& session() const { return participant_.session(); }
  PeerId self() const { return replica().self(); }
  /// Null if the session has no key.
  const node::SecureChannels* channels() const { return participant_.channels(); }
  /// The member through which p is reached; kNoPeer: it is reached directly.
  Endpoint place(PeerId p) const { return participant_.place(p); }
  PeerId carrier(PeerId p) const { return participant_.carrier(p); }
  /// Of the present incarnation; only when playing.
  const node::Replica& replica() const { return participant_.replica(); }
  /// Counted from 0.
  int incarnation() const { return participant_.incarnation(); }
  bool returning() const { return participant_.returning(); }
  /// Peers that are there, this one included.
  int present() const;
  /// Play has begun, and this peer has been in it.
  bool has_begun() const { return first_tick_ >= 0; }
  /// First tick played, of the first incarnation; -1: not yet.
  Tick first_tick() const { return first_tick_; }
  /// When it was, us; -1: not yet.
  Micros joined_at() const { return joined_at_; }
  const TickStats& ticks() const { return ticks_; }
  Totals totals() const;
  const History& history() const { return history_; }
  History::Checkpoint confirmed() const { return history_.confirmed(incarnation()); }

 private:
  node::ParticipantConfig config(const node::SessionConfig& session, std::optional<node::ChannelConfig> channels);
  void go_on(Micros now);
  void step(Micros now);
  void begin_incarnation();
  void follow_start(Micros now);
  void say_what_is_played();
  void watch_clock(Micros now);
  void watch_hashes();
  void tell_events(Micros now);
  /// Whether the log has a line for this refusal; counts it if not.
  bool tells_refusal(const std::string& words, Micros now);
  void tell(Micros now);

  const Options& options_;
  Log& log_;
  Recordings& recordings_;
  Watcher* watcher_;
  Technique technique_;  ///< as it is now
  monitor::Steering steering_;
  Standstill still_;
  bool catching_up_ = false;                ///< after a standstill, which is nobody's fault
  node::Allowance refusals_{1, 10, 10, 0};  ///< of which the log has a line each
  int refused_untold_ = 0;
  std::string refused_;    ///< the last of those lines, and when it was said
  int refused_again_ = 0;  ///< times that it would have been said since
  Micros refused_at_ = 0;
  History history_;
  node::Participant participant_;
  std::unique_ptr<scenarios::InputSource> input_;
  TickStats ticks_;
  Totals past_;     ///< of incarnations gone by
  Totals present_;  ///< of the present one, as of its last step
  Tick first_tick_ = -1;
  bool waited_ = false;  ///< for the begin of play, which has not been told yet
  Tick last_input_;      ///< the target stands still from here on
  Micros joined_at_ = -1;
  Micros stepped_at_ = -1;
  int known_incarnation_ = -1;
  bool mismatch_told_ = false;
};

}  // namespace padr::peer
