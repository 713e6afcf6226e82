#pragma once

#include <array>
#include <cassert>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/channel/outbox.h"
#include "common/channel/secure_channels.h"
#include "common/participant/allowance.h"
#include "common/participant/session.h"

namespace padr::node {

struct ParticipantConfig {
  SessionConfig session;                  ///< scene_hash, authority and sealed are filled in, fingerprint if it is 0
  ReplicaConfig replica;                  ///< give technique and fault; the participant sets the rest
  std::optional<ChannelConfig> channels;  ///< the session has a key; otherwise nothing is sealed
  /// Steers its session's clock with its steps. Otherwise the caller does, as in a crowd, where a peer has one clock.
  bool steers = true;
  /// Rate at which this peer passes on datagrams of other members, besides as much as it sends itself, bytes/s.
  double carries = 8'000;
  /// Longest wait after leave() for the others to acknowledge this peer's last updates, us.
  Micros linger = 3 * kMicrosPerSecond;
  /// Where the n-th incarnation of this peer (0, 1, ...) is recorded to; empty or nothing returned: nowhere.
  std::function<std::optional<RecordedReplica::Recording>(int incarnation)> recording;
  /// For tests only: what becomes of a datagram before it is sealed and sent.
  std::function<std::vector<Parcel>(Parcel)> tamper{};
  /// As Replica's, with the number of the incarnation.
  std::function<void(int incarnation, const sync::FoldState& state, std::uint64_t hash)> on_confirmed;
};

/// A whole peer except for its clock, socket and input. It founds or joins a session, waits for the members that play
/// needs, and plays. It joins anew after an eviction, a difference of confirmed worlds or a lost merge of partitions:
/// each time as a new incarnation, with a fresh replica that begins with the agreed world. The old one goes on until
/// the new one is admitted.
class Participant {
 public:
  /// `local`: microseconds on any monotonic clock of the caller's, the same for all calls. Throws UserError if the
  /// session that it is to found has more slots than the scene has places to start from, or wants more peers than
  /// slots, or if a field of the technique is out of range.
  Participant(const Scene& scene, ParticipantConfig config, Micros local);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local);
  /// The machine at `at` reports that nobody listens there. Ignored in a session with a key.
  void unreachable(const Endpoint& at, Micros local);
  /// Upkeep besides the ticks; call at least whenever next_due() has come.
  void advance(Micros local);
  Micros next_due() const;

  /// Whether there is a world to step: this peer has founded the session, or is admitted. Nothing moves in that world
  /// until replica().playing(): as many players have come as the session waits for.
  bool playing() const { return current_.replica != nullptr; }
  /// Local time of the next step; only when playing.
  Micros next_step() const;
  /// Whether the next step is due, and fewer than kStepsPerTurn steps have been made with the same `local`: datagrams
  /// must get their turn, or catching up makes everything worse.
  bool step_due(Micros local) const;
  static constexpr int kStepsPerTurn = 8;
  /// One tick, with the avatar driven towards `target` (m); only when playing. Others believe no target beyond 10 km:
  /// one beyond 9 km is moved to 9 km in its direction, from the middle of the scene in a region of a crowd and from
  /// zero otherwise. In place of one that is not finite the last one counts.
  void step(Vec2 target, Micros local);
  /// Changes the knobs from the next step on, in later incarnations, too. Throws UserError if a field of the technique
  /// is out of range, or `authority` changes.
  void retune(const Technique& technique);
  /// As in Replica: one tick in a region where this peer is a guest.
  void step_led(const BodyState& from, const BodyState& to, Vec2 target, Micros local);
  /// Corrects the session's clock towards that of the most senior peer present, as far as is known; only when playing.
  void steer(Micros local);
  // As in RecordedReplica, of the present incarnation; only when playing.
  void order(const sync::Bundle& order) { played().order(order); }
  /// For crowds, whose peers are not recorded: a trace does not have it, and does not replay afterwards.
  void jolt(Vec2 velocity) { played().jolt(velocity); }
  void set_coarseness(float times) { played().set_coarseness(times); }
  /// Adds to a body's velocity (m/s), as if this peer's avatar had touched it, with authority over it from then on.
  /// Does nothing before play has begun, and while another peer holds the body: see Replica::may_push. No body gets
  /// faster than 60 m/s. Throws UserError if there is no such body, or the velocity is not finite or above
  /// trace::Push::kMost, 1000 m/s.
  void push(EntityId b, Vec2 velocity);
  void remark(const trace::Remark& r) { played().remark(r); }
  /// Sends a Probe to a peer that claims to be in this session but is no member, so that partitions merge.
  void knock(const Endpoint& at);
  /// Leaves: with the next step when playing, or some ticks later in a large session. `stay`: also waits until the
  /// others end, so that they get the updates that they lack.
  void leave(Micros local, bool stay = false);
  bool leaving() const { return left_at_.has_value(); }
  /// After leave: all others have this peer's updates, no other is present, it has lingered for long enough, or it is
  /// not in yet.
  bool done(Micros local) const;

  /// What to send, in order; empty afterwards. Good until the next call of any other function.
  std::span<const Parcel> take_outgoing();
  /// What happened since the last call.
  std::vector<SessionEvent> take_events();
  /// Members that were admitted, left or were removed since the last call.
  std::vector<MemberChange> take_changes();

  /// Of the present incarnation; only when playing.
  const Replica& replica() const { return recorded().replica(); }
  const RecordedReplica& recorded() const {
    assert(playing());
    return *current_.replica;
  }
  const Session& session() const { return current_.session ? *current_.session : *next_.session; }
  Session& session() { return current_.session ? *current_.session : *next_.session; }
  /// Incarnations begun so far, less one.
  int incarnation() const { return begun() - 1; }
  bool returning() const { return playing() && next_.session != nullptr; }
  /// This peer was not admitted, or left because too few members came; session().failure() says why.
  bool failed() const {
    if (!current_.session) return next_.session->phase() == SessionPhase::kFailed;
    return !current_.session->failure().empty() && done(local_);
  }
  /// Whether somebody at this address is a member, or was one and is looked for.
  bool knows(const Endpoint& at) const { return current_.membership && current_.membership->knows(at); }
  /// Only when playing.
  PeerId coordinator() const;
  /// Where the peer in a slot is: with a key, by what it sent last, which need not be where the session has it. Only
  /// when playing.
  Endpoint place(PeerId p) const;
  /// The member through which p is reached; kNoPeer: it is reached directly, as far as is known.
  PeerId carrier(PeerId p) const { return current_.membership ? current_.membership->carrier(p) : kNoPeer; }
  /// Null if the session has no key.
  const SecureChannels* channels() const { return channels_ ? &*channels_ : nullptr; }
  /// Ends the trace. Nothing may be called afterwards but the getters.
  void finish();

 private:
  struct Incarnation {
    std::unique_ptr<Session> session;
    std::unique_ptr<RecordedReplica> replica;
    std::unique_ptr<Membership> membership;     ///< once the replica has caught up
    std::vector<sync::Transfer::Gone> gone;     ///< of the transfer that it began with
    std::vector<sync::Transfer::Proof> proofs;  ///< of that, too
  };
  RecordedReplica& played() {
    assert(playing());
    return *current_.replica;
  }
  void bring_in_next(Micros local);
  /// It has failed: says why, now and then.
  void drop_attempt(Micros local);
  void give_up_entering(Micros local);
  void ask_again(Micros local);
  /// Why the scene has no room for the session's slots; empty if it has.
  std::string no_room_for(const Session& session) const;
  void found();
  void found_anew(Micros local);
  /// Begins the next incarnation with this state, which is the session's at `now`.
  void go_on_from(const sync::Transfer& start, const ReplicaConfig& config, Tick now);
  void give_up_waiting(Micros local);
  /// A target that others believe: this one, if it is one.
  Vec2 usable(Vec2 target);
  /// By how much the step begins after the time of its tick, us.
  Micros before_step(Micros local);
  void after_step(Micros local);
  /// By how much the next step is late, us.
  Micros lateness(Micros local) const;
  /// This peer may have stood still until now.
  void note_sleep(Micros local);
  void begin_with_transfer(Micros local);
  void catch_up(Incarnation& incarnation, Micros local);
  void watch(Incarnation& incarnation, Micros local);
  void take_over();
  /// Whether another member is to be asked than the one that this peer tries to join anew by.
  bool asks_in_vain(const Endpoint& way_back) const;
  void look_for_way_back(Micros local);
  /// Whether play has not begun, and the founder is gone.
  bool waits_without_founder() const;
  void announce_founder_is_gone();
  bool is_of_this_session(const Session& session) const;
  void note_time(Micros local);
  void plan_farewell();
  void say_goodbye();
  bool nobody_to_tell() const;
  void use_introductions();
  void use_carriers();
  void introduce_carried();
  void collect(Incarnation& incarnation);
  void take(const SecureChannels::Arrival& arrival, Micros local);
  bool may_carry(const Endpoint& from, const Endpoint& to, std::size_t bytes);
  void post(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes);
  void hand_over(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes);
  void warn_of_last_key();
  void warn_of_drops(const Endpoint& place, Micros local);
  ReplicaConfig replica_config(const Session& session) const;
  /// Incarnations begun so far.
  int begun() const { return static_cast<int>(had_.size()); }
  /// Where the incarnation that is being begun is recorded, if anywhere.
  std::optional<RecordedReplica::Recording> recording() const;
  Replica::ConfirmedSink sink();

  Scene scene_;
  ParticipantConfig config_;
  std::optional<SecureChannels> channels_;
  Micros local_;                                      ///< of the last call
  Micros turn_ = std::numeric_limits<Micros>::min();  ///< `local` of the last step
  int steps_ = 0;                                     ///< made with it
  std::uint64_t drops_seen_ = 0;
  std::uint64_t drops_told_ = 0;
  Endpoint dropped_at_;             ///< where the last of them came from
  std::optional<Micros> doubtful_;  ///< since when something of somebody that is not heard has been dropped
  Micros warned_;
  bool last_key_told_ = false;
  Incarnation current_;             ///< the present one, once there is one
  Incarnation next_;                ///< one that is being begun
  std::vector<std::uint32_t> had_;  ///< its incarnations so far, as the wire has them
  Micros began_;
  Tick steered_ = 0;
  /// What links show of clocks goes back no further than this.
  static constexpr Tick kClocksShowOf = 7 * kTicksPerSecond;
  Tick skipped_ = -kClocksShowOf;  ///< when the clock was last set right at once
  std::optional<Vec2> target_;     ///< m, of the last step
  std::optional<Micros> left_at_;  ///< local time of leave()
  std::optional<Tick> farewell_;   ///< tick at which to leave; absent: done, or not planned yet
  bool stays_ = false;
  /// See SessionConfig; of the next incarnation.
  std::optional<Micros> most_offset_;
  bool misses_founder_ = false;  ///< that has been told
  bool doubts_time_ = false;     ///< a transfer has shown another time than this incarnation's
  Micros try_again_ = 0;
  std::optional<Micros> failed_;  ///< when it was last told why this peer has not come in
  std::uint64_t tries_ = 0;
  Allowance for_members_;                        ///< what this peer may carry
  Allowance for_newcomers_;                      ///< what it may carry between them and the coordinator
  std::array<PeerSet, kMaxPeers> carried_to_{};  ///< by receiver: whose datagrams it has carried there lately
  Micros introduced_;                            ///< when it last told them where it sees those
  Outbox outgoing_;
  std::vector<SessionEvent> events_;
  std::vector<MemberChange> changes_;
};

/// The tick, and the first entity and field, in which two confirmed states of the same tick differ; empty if in none.
std::string first_difference(const sync::FoldState& ours, const sync::FoldState& theirs);

}  // namespace padr::node
