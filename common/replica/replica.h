#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/model/scene.h"
#include "common/model/technique.h"
#include "common/reckoning/live_world.h"
#include "common/reckoning/reporter.h"
#include "common/reckoning/threshold.h"
#include "common/reckoning/unowned.h"
#include "common/replica/hash_checks.h"
#include "common/replica/link_state.h"
#include "common/replica/roster.h"
#include "common/shown/convergence.h"
#include "common/sync/agreed_world.h"
#include "common/sync/transfer.h"
#include "common/sync/validation.h"
#include "common/wire/codec.h"
#include "common/wire/seal.h"

namespace padr::node {

struct ReplicaConfig {
  PeerId self = 0;
  int peers = 1;                  ///< of the session at tick 0
  int wanted = 0;                 ///< members that play waits, or waited, for
  int slots = 1;                  ///< avatar slots, >= peers
  std::uint32_t incarnation = 0;  ///< of this peer in its slot; above 0 for a peer that joined later
  std::uint16_t session = 0;      ///< in every datagram's header
  SessionId session_id{};         ///< in every signature
  bool spectates = false;         ///< this peer has no avatar
  Technique technique;
  sync::Fault fault;             ///< for tests only
  std::size_t kept_ticks = 512;  ///< see AgreedConfig
  /// In a session with a key: signs an update of this peer's. Empty: they go out unsigned.
  std::function<sync::Signature(const sync::Bundle&)> sign{};

  sync::AgreedConfig agreed() const {
    sync::AgreedConfig c{slots, peers, self, technique.authority, technique.replay, fault, kept_ticks};
    c.time_stamps = technique.time_stamps;
    const int players = spectates ? peers - 1 : peers;
    c.wanted = wanted > players ? wanted : 0;
    return c;
  }
};

/// Bytes of IPv4 and UDP headers that every datagram costs besides its payload.
inline constexpr std::size_t kIpUdpBytes = 28;

struct Outgoing {
  PeerId to = kNoPeer;
  wire::Bytes bytes;
};

/// Counters since the start; never reset.
struct ReplicaStats {
  std::array<std::uint64_t, sync::kCauses> updates_by_cause{};  ///< entity updates, each once however often sent
  std::uint64_t bundles = 0;
  std::uint64_t datagrams_sent = 0;
  std::uint64_t wire_bytes_sent = 0;  ///< IP and UDP headers included
  std::uint64_t repeats = 0;          ///< bundles sent again
  std::uint64_t datagrams_received = 0;
  std::array<std::uint64_t, sync::kDropReasons> dropped{};
  std::uint64_t hash_checks = 0;
  std::uint64_t hash_mismatches = 0;
  Tick first_mismatch = -1;
};

/// The core of one peer: everything from bytes and input in to bytes out. It has no clock and no socket: the same
/// object runs in the real process, in the lab and in tests, and the same calls give the same bits.
class Replica {
 public:
  using ConfirmedSink = sync::AgreedWorld::ConfirmedSink;
  /// Judges a packet with valid values, which may still be forged or be an order without right; kNone if it may pass.
  /// `relayed_by`: the member that relayed it; kNoPeer: it came from its peer.
  using Judge = std::function<sync::DropReason(const sync::StatePacket& packet, PeerId relayed_by)>;

  /// For a peer that is present at tick 0.
  Replica(const Scene& scene, const ReplicaConfig& config, ConfirmedSink on_confirmed = {});
  /// For a peer that joins a running session at tick `now`, and watches until it is admitted. It begins at the
  /// transfer's tick: nothing but catch_up may be called until that is done. For a peer that founds a session, which
  /// is a member in the transfer's state, that is all: it is in at once.
  Replica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start, Tick now,
          ConfirmedSink on_confirmed = {});
  /// Steps towards the tick at which it joins, by at most `most` ticks. Returns whether that tick is reached.
  bool catch_up(Tick most);
  // Its parts refer to it.
  Replica(const Replica&) = delete;
  Replica& operator=(const Replica&) = delete;

  /// Takes a datagram that arrived at `now`, in session microseconds. Returns why it was dropped, kNone if it was not.
  sync::DropReason receive(const wire::Opened& opened, Micros now);
  /// The same for a datagram that has not been opened yet.
  sync::DropReason receive(std::span<const std::byte> datagram, Micros now);
  /// The judge is asked before anything of a datagram is taken in. A datagram that it rejects changes only counters.
  void set_judge(Judge judge) { judge_ = std::move(judge); }
  /// Whether it has rejected the last datagram.
  bool judge_objected() const { return objected_; }
  /// Counts a datagram of p that was dropped unread.
  void count_drop(PeerId p, sync::DropReason why);
  /// Counts that datagrams of p are ignored from now on, for good or for a while.
  void count_cut_off(PeerId p) { ++links_[p].cut_offs; }
  /// Signature of the update that this peer published with the last step; nothing if there is no such update or no key.
  std::optional<sync::Signature> signed_now() const;
  /// Advances to the next tick with the avatar driven towards `target` (m); `outgoing` then holds what to send.
  void step(Vec2 target);
  /// The same in a region of a crowd where this peer is a guest: another of its worlds leads the avatar, which moves
  /// from `from` to `to` in this tick and is driven towards `target` there.
  void step_led(const BodyState& from, const BodyState& to, Vec2 target);
  /// Change of the avatar's velocity by its contacts in the last step_led, m/s.
  Vec2 reaction() const { return reaction_; }
  /// Adds to the avatar's velocity, m/s, before the next step: for a contact in another of its worlds.
  void jolt(Vec2 velocity) { jolt_ = jolt_ + velocity; }
  /// Multiplies the avatar's threshold by `times`, >= 1, until a contact is predicted; for an avatar with no peer near.
  void set_coarseness(float times) { coarseness_ = times; }
  /// Datagrams of the last step, at most one per receiver.
  std::span<const Outgoing> outgoing() const { return {outgoing_.data(), sent_}; }
  /// The next step without an order publishes that this peer leaves. Keep stepping until `delivered`.
  void leave() { roster_.leaving = true; }
  /// After leaving: every peer that is still reachable has all of this peer's updates, this peer has all of theirs that
  /// it knows of, and there was time to acknowledge them. It may end.
  bool delivered() const;

  // Membership. The coordinator publishes its decisions by `order`, one order a tick. They are a part of the agreed
  // world: all peers apply them at the same tick.

  /// Queues an order, published in place of an ordinary update: an admission, removals or a passed-on update, no more.
  void order(const sync::Bundle& order) { orders_.push_back(order); }
  std::size_t orders() const { return orders_.size(); }
  /// Stops taking updates from p, while the end of its log is being agreed on, or resumes.
  void freeze(PeerId p, bool frozen);
  /// The session's roster, as this peer knows it.
  const Roster& roster() const { return roster_; }
  const Seat& seat(PeerId p) const { return roster_.seats[p]; }
  bool member() const { return roster_.member; }
  /// This peer has been removed by others, or has updates of a removed peer that they have declared void.
  bool expelled() const { return expelled_; }
  /// The lowest peer whose confirmed world differs from ours; kNoPeer if none does.
  PeerId differs_from() const { return differs_from_; }
  /// All that a joiner needs to continue from here.
  sync::Transfer transfer() const;
  /// Where the session goes on with nobody in it but this peer, as `incarnation`: see sync::founding_anew.
  sync::Transfer founding_anew(std::uint32_t incarnation) const;
  const LinkState& link(PeerId p) const { return links_[p]; }
  /// Sets the address of p, in a session whose peers are all present from tick 0 on.
  void locate(PeerId p, const Endpoint& at) { roster_.seats[p].at = at; }
  /// Members that were admitted, left or were removed since the last call.
  std::vector<MemberChange> take_changes();
  /// As in Roster; what p has promised and not told no longer holds up the confirmed world.
  void give_up(PeerId p, bool for_good);
  /// Takes updates of p from another member, which hears p while we do not. They are judged as if they came from p
  /// itself, and none is taken if one is rejected. An update also implies, like a mark, that those before it are all of
  /// earlier ticks.
  sync::DropReason relay(PeerId p, std::uint32_t incarnation, const std::vector<sync::Bundle>& updates, PeerId by);
  /// Changes the knobs from the next step on. Each peer may choose its own, except for `authority`, which must stay.
  void retune(const Technique& technique);
  /// Whether a push of this body would take effect now: no other peer holds it, and this peer plays.
  bool may_push(EntityId b) const;
  /// With the next report this peer takes authority over the body, unless it may not after all, and adds to its
  /// velocity (m/s), as if its avatar had touched it. Without dynamic authority it does so in its own world alone.
  void push(EntityId b, Vec2 velocity) { pushes_[b] = pushes_[b] + velocity; }
  /// As in Roster.
  void excuse_tick() { roster_.excuse_tick(); }

  Tick now() const { return agreed_.now(); }
  /// The begin of play, as far as it is confirmed: until then targets and pushes have no effect. A predicted begin may
  /// be taken back, if a leave update comes late.
  sync::Start start() const { return agreed_.confirmed().start; }
  bool playing() const { return start().reached(now()); }
  PeerId self() const { return config_.self; }
  const ReplicaConfig& config() const { return config_; }
  const sync::AgreedWorld& agreed() const { return agreed_; }
  const sync::LiveWorld& live() const { return live_; }
  const sync::Shown& shown() const { return shown_; }
  const ReplicaStats& stats() const { return stats_; }
  const sync::Reporter& reporter() const { return reporter_; }
  float threshold() const { return threshold_.metres() * price_ * (prediction_.interaction ? 1 : coarseness_); }
  /// What all thresholds are multiplied by, so that links and budget take what is told: see sync::price_of. 1
  /// without a budget.
  float price() const { return price_; }
  /// The prediction that the threshold was last adapted to; it was also adapted to present contacts.
  const sync::Prediction& prediction() const { return prediction_; }
  /// Sizes of what a peer keeps because it may still be needed; bounded however long a session lasts.
  struct Kept {
    std::size_t log_ticks = 0;       ///< ticks with updates above the confirmed one
    std::size_t own_updates = 0;     ///< bundles not acknowledged by all peers, or recent
    std::size_t pending_checks = 0;  ///< others' hashes of ticks not confirmed here yet
  };
  Kept kept() const { return {agreed_.log().size(), own_log_.size(), checks_.waiting()}; }
  std::uint64_t lookahead_steps() const { return predictor_.steps(); }
  /// Longest interval between own updates while a member does not answer, ticks.
  static constexpr Tick kHeartbeat = kTicksPerSecond / 2;
  /// Time for which a peer is told the hash of the tick of which its own hash was another one, ticks.
  static constexpr Tick kTellContested = 4 * kTicksPerSecond;
  /// The other peer present that was admitted first; kNoPeer if nobody else is.
  PeerId most_senior_other() const;
  /// By how much this peer's session clock leads that of the most senior other peer, in microseconds, as far as delays
  /// are alike both ways; 0 until measured.
  Micros clock_lead() const;
  /// By how much it leads those of more than half of the other members at least, in microseconds, whatever the delays
  /// are; 0 if not, or if there is only one other.
  Micros least_clock_lead() const;
  /// By how much it is behind theirs, likewise.
  Micros least_clock_lag() const;
  /// Whether most of at least two others have a clock that differs from this one by less than kFarBehind.
  bool shares_time() const;
  /// Lead from which on this peer has been told a wrong time, us: the others drop what it sends from 2 s on.
  static constexpr Micros kFarAhead = kMicrosPerSecond;
  /// Lag from which on this peer's clock has stood still for a while, as that of a suspended machine does, us.
  static constexpr Micros kFarBehind = kMicrosPerSecond / 4;
  /// Sum over own entities of the distance between the live and the predicted world (m): the error that the others are
  /// believed to see.
  float own_error() const;
  /// Hash over the live world's entity states, for comparing runs.
  std::uint64_t live_hash() const;

 private:
  // Interval between the confirmed ticks whose hashes are exchanged.
  static constexpr Tick kCheckEvery = 30;

  struct Later {};
  Replica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start, ConfirmedSink on_confirmed,
          Later);

  /// What more than half of the other members show at least, us; 0 if that is negative, or there is only one other.
  Micros as_most_others_show(Micros (LinkClock::*what)() const) const;
  ConfirmedSink check_and(ConfirmedSink sink);
  sync::DropReason take(const wire::Opened& opened, Micros now);
  /// Why the packet is to be dropped; kNone: it is not. Only `objected_` changes.
  sync::DropReason examine(const sync::StatePacket& packet, PeerId from);
  void note_time();
  Tick came_at(Micros now) const;
  sync::DropReason check_claims(const sync::StatePacket& packet, PeerId from) const;
  bool repeats(const sync::StatePacket& packet, PeerId from) const;
  bool breaks_promise(const sync::StatePacket& packet, PeerId from) const;
  sync::DropReason file_updates(const sync::StatePacket& packet, PeerId from);
  void file(const sync::Bundle& bundle);
  void note_farewell(const sync::Bundle& b);
  /// Whoever sat in the slot has published no more than `count` updates.
  void close(PeerId p, std::uint32_t count);
  void note_changes(const sync::Bundle& bundle);
  void admit(const sync::Admission& a, const sync::Bundle& by);
  /// This peer is in, in the tick `since`; `first`: number of its first update, `by`: the slot of who let it in.
  void take_seat(std::uint32_t first, Tick since, const Endpoint& at, PeerId by);
  void keep_places(const sync::Transfer& start);
  void remove(const sync::Removal& r, const sync::Bundle& by);
  Tick told_until(PeerId p) const;
  void forgive_arrears();
  /// The time in which p could not tell anything does not count as arrears.
  void forgive(PeerId p, Tick meanwhile);
  void take_check(const sync::StatePacket& packet, PeerId from);
  void settle_checks();
  bool publish_order();
  void publish_heartbeat();
  void keep_logs(std::uint32_t everyone);
  bool all_through() const;
  /// `as_stepped`: as in LiveWorld::adopt.
  void adopt(bool as_stepped = false);
  void report(Vec2 target, Vec2 velocity_before);
  void report_as_spectator();
  void take_on_rounded(const sync::Bundle& told);
  void look_ahead(Vec2 target);
  std::vector<EntityId> push_bodies();
  void forget_pushes(const sync::Bundle& told);
  void publish(const sync::Bundle& bundle);
  void send();
  /// Peers that datagrams go to.
  int links() const;
  /// `check_every`: ticks between hashes told to one peer.
  void fill(sync::StatePacket& packet, PeerId p, Tick check_every);
  const HashChecks::Own* contested_check(PeerId p) const;
  void refresh_own();
  bool own_is_predicted(const std::vector<bool>& own) const;
  const std::vector<bool>& kept_from_live();
  void go_on(Vec2 target, Vec2 velocity_before);
  void compare(Tick t, std::uint32_t theirs, PeerId from);
  std::uint32_t own_end() const { return own_first_ + static_cast<std::uint32_t>(own_log_.size()); }

  Scene scene_;
  ReplicaConfig config_;
  Judge judge_;
  bool objected_ = false;  ///< the judge, to the last datagram
  HashChecks checks_;      ///< at check ticks; filled by agreed_ from its construction on
  sync::AgreedWorld agreed_;
  sync::LiveWorld live_;
  sync::Reporter reporter_;
  sync::InteractionPredictor predictor_;
  sync::Threshold threshold_;
  sync::Prediction prediction_;
  Tick looked_ = -1000;  ///< when the last look ahead was taken
  sync::Shown shown_;
  Ring<sync::Bundle> own_log_;   ///< not yet acknowledged by all peers, or recent
  sync::BundlePool own_pool_;    ///< for own_log_
  std::uint32_t own_first_ = 0;  ///< index of own_log_.front()
  Roster roster_;
  std::vector<LinkState> links_;  ///< by slot
  std::deque<sync::Bundle> orders_;
  std::map<EntityId, Vec2> pushes_;  ///< to be made with the next report, m/s
  std::vector<MemberChange> changes_;
  std::vector<EntityId> mine_;  ///< own entities, ascending
  std::vector<bool> own_;       ///< the same by entity id
  std::vector<bool> kept_;      ///< scratch
  sync::UnownedBodies unowned_;
  std::vector<Outgoing> outgoing_;  ///< with room from earlier ticks
  std::size_t sent_ = 0;            ///< of outgoing_, this tick
  wire::StateEncoder encoder_;
  wire::StateDecoder decoder_;
  ReplicaStats stats_;
  std::uint64_t repeats_of_gone_ = 0;
  Tick comes_at_ = 0;  ///< see catch_up
  Vec2 reaction_;
  Vec2 jolt_;
  float coarseness_ = 1;
  float price_ = 1;
  bool joined_ = false;  ///< the live world has taken over the own avatar as it was admitted
  bool expelled_ = false;
  PeerId differs_from_ = kNoPeer;
  bool gone_ = false;
  Tick news_ = 0;  ///< when the last new update arrived or was made
  Tick through_ticks_ = 0;
  Tick told_in_full_ = 0;  ///< when what was due last did not have to wait
};

/// The same hash over the entity states of an agreed world.
std::uint64_t state_hash(const sync::FoldState& s);

}  // namespace padr::node
