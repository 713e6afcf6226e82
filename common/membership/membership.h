#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/membership/admissions.h"
#include "common/membership/evictions.h"
#include "common/membership/misbehaviour_policy.h"
#include "common/membership/partition_merge.h"
#include "common/membership/testimony.h"
#include "common/membership/vouching.h"
#include "common/paths/introductions.h"
#include "common/paths/paths.h"
#include "common/paths/relay.h"
#include "common/session/applied_commands.h"

namespace padr::node {

/// One member's part in the membership of a running session: passes each message to the rule that it concerns, follows
/// the changes once a tick, and decides when this peer has to join anew.
class Membership {
 public:
  /// Both must outlive it.
  Membership(SessionState& session, RecordedReplica& replica);

  void on_join(const Endpoint& from, const wire::Join& join, Micros local);
  /// Replies only to a joiner.
  void on_ping(const Endpoint& from, const wire::Ping& ping, Micros local) {
    admissions_.on_ping(from, ping, local, commands_);
  }
  /// `bytes`: of the whole datagram.
  void receive(const Endpoint& from, const wire::Header& header, const wire::MembershipMessage& message,
               std::size_t bytes, Micros local);
  /// A state datagram from an address of no member, or of a removed peer.
  void on_stranger(const Endpoint& from, std::size_t bytes, Micros local) {
    merge_.on_stranger(from, bytes, view(), local, commands_);
  }
  /// Whether p is another slot than ours, and its present or last occupant is at this address.
  bool is_at(PeerId p, const Endpoint& where) const {
    return p < session_.slots && p != session_.self && roster().seats[p].at == where;
  }
  /// The member whose place this is; kNoPeer: nobody's.
  PeerId member_at(const Endpoint& where) const;
  /// Whether datagrams of member p are taken.
  bool hears(PeerId p) const { return misbehaviour_.hears(p, view()); }
  /// A state datagram of member p was dropped.
  void on_drop(PeerId p, sync::DropReason why, Micros local) {
    misbehaviour_.on_drop(p, why, view(), local, commands_);
  }
  /// A state datagram of member p has come directly.
  void note_direct(PeerId p) { paths_.note_direct(p, roster().now); }
  /// Whether datagrams of one of the two are to be passed on to the other: both are members whose datagrams are taken.
  bool may_carry(const Endpoint& from, const Endpoint& to) const;
  /// Whether one of the two is a newcomer, and the other one the coordinator that it was told to ask by this peer.
  bool may_introduce(const Endpoint& from, const Endpoint& to) const {
    return roster().member && introductions_.may_carry(from, to);
  }
  /// At the coordinator: newcomers that other members have told to ask it, and those members.
  const std::vector<Introductions::Introduction>& introduced() const { return introductions_.introduced(); }
  /// The member through which p is reached; kNoPeer: it is reached directly.
  PeerId carrier(PeerId p) const { return paths_.carrier(p); }
  /// See Paths.
  std::vector<Endpoint> addresses(PeerId p) const { return paths_.addresses(p); }
  /// Tells member `to` where this peer, which carries between the two, sees another one.
  void introduce(const Endpoint& who, PeerId to) { commands_.send(roster().seats[to].at, wire::Newcomer{who}); }
  /// Whether it is not known which ways to p work, so that what is carried for it goes directly, too.
  bool is_unsure_of(PeerId p) const { return !paths_.has_told(p, roster().now); }
  /// The machine at `at` reports that nobody listens there.
  void on_unreachable(const Endpoint& at);
  /// Whether the address is another member's, or an evicted peer's that is looked for.
  bool knows(const Endpoint& at) const { return merge_.knows(at, view()); }
  /// Sends one Probe to `at`, which lists the members of this session.
  void knock(const Endpoint& at) { merge_.knock(at, view(), commands_); }
  /// A peer that was evicted from this session, by the word of the transfer; or one of a session that this peer was in
  /// before.
  void remember(const sync::Transfer::Gone& gone) { merge_.remember(gone, roster().now); }
  /// Proofs of the transfer.
  void take(const std::vector<sync::Transfer::Proof>& proofs);
  /// Whether there is proof that the peer with this key has lied: this peer joins nobody by it.
  bool convicts(const PublicKey& key) const { return testimony_.convicts(key); }
  /// Whether the peer with this key is barred: it may not join.
  bool bars(const PublicKey& key) const;
  /// Bans, proofs and places that this peer's former incarnation knew. `let_in_by`: key of who has let this peer in
  /// anew, if anybody has.
  void inherit(const Membership& before, const PublicKey& let_in_by);
  /// See PartitionMerge.
  void note_sleep() { merge_.note_sleep(roster().now); }
  /// Once a tick, after the replica's step.
  void advance(Micros local);
  /// Address at which to join anew after an eviction, a difference of confirmed worlds, a standstill or a lost merge of
  /// partitions; nothing if all is well.
  std::optional<Endpoint> way_back() const;
  /// How many Joins may go there now, which count as sent; absent: any number.
  std::optional<int> joins_for(const Endpoint& at) { return merge_.joins_for(at, view()); }
  /// Whether this peer should ask at way_back() rather than at this address, where it has asked to join anew: the
  /// member there has left, or nobody is known to live.
  bool asks_in_vain(const Endpoint& at) const;
  /// Whether this peer has left its seat and found nobody for so long that it has to found the session anew.
  bool founds_anew() const;
  /// Leaves this peer's seat, so that it can have it anew: the session, which it has to join anew, is full.
  void give_seat_back();
  /// Reports once, as an event, that this peer joins anew, and why.
  void announce_way_back();
  PeerId coordinator() const { return evictions_.coordinator(view()); }
  /// Members that were admitted, left or were removed since the last call.
  std::vector<MemberChange> take_changes();

 private:
  bool bars_for_good(const PublicKey& key) const;
  /// What a joiner that is barred is told.
  std::string ban_of(const PublicKey& key) const;
  const Roster& roster() const { return replica_.replica().roster(); }
  View view() const {
    View view = view_of(replica_.replica());
    view.returning = returning_;
    return view;
  }
  sync::Transfer transfer() const;
  void receive_of_member(PeerId member, const wire::MembershipMessage& message, Micros local);
  /// Another one that is there; kNoPeer: none.
  PeerId member_with(const PublicKey& key) const;
  void on_newcomer(PeerId by, const wire::Newcomer& newcomer, Micros local);
  sync::DropReason judge(const sync::StatePacket& packet, PeerId relayed_by);
  void follow_testimony();
  /// A slot of whose former occupant an update has been missing here for long; kNoPeer: there is none.
  PeerId lacks_former() const;
  /// Whether this peer confirms nothing, and another member does.
  bool is_overtaken() const;
  /// Leaves this peer's seat if it is the coordinator and has to join anew.
  void step_down();
  /// The most senior living member but this peer, whoever has misled it, and those whom it has cut off; kNoPeer if
  /// there is none.
  PeerId guide() const;
  void follow_changes();
  void count_present();
  void find_paths();
  void find_dead_links();
  void note_former_incarnations(const std::vector<MemberChange>& changes);
  void end_former_incarnations();
  /// Whether an eviction may be near.
  bool doubts() const;
  void watch_confirmed();
  /// Whether this peer has left its seat to join anew, and no member is known to live by which it could.
  bool is_alone() const { return stands_down_ && guide() == kNoPeer; }
  /// Where a member is or was.
  std::optional<Endpoint> place_of_somebody() const;
  std::string why_back() const;
  /// Counts whoever does not let this peer in anew as silent, after a while.
  void give_up_guide();
  /// Whether nothing is confirmed, and the coordinator c has not asked about a peer that has been silent for long.
  bool spares_silent(PeerId c) const;
  /// Whether c's confirmed hash differs though it has let this peer in anew when it differed, and all others agree with
  /// this peer.
  bool is_odd_one_out(PeerId c) const;

  const SessionView& session_;
  RecordedReplica& replica_;
  AppliedCommands commands_;
  Admissions admissions_;
  Introductions introductions_;
  Evictions evictions_;
  Relay relay_;
  MisbehaviourPolicy misbehaviour_;
  PartitionMerge merge_;
  Testimony testimony_;
  Vouching vouching_;
  Paths paths_;
  std::vector<Paths::Link> links_;  ///< by slot, as measured last
  PeerSet dead_links_ = 0;          ///< without a key: to whom, as told last
  std::vector<MemberChange> changes_;
  PeerSet returning_ = 0;  ///< members that have asked this peer to let them in anew
  struct Refused {
    Tick since = 0;
    bool believed = false;  ///< and this peer has begun to declare it gone
  };
  std::map<PeerId, Refused> refused_;       ///< whose machines report that nobody listens there
  std::map<PeerId, std::uint32_t> former_;  ///< slots and incarnations of peers that were admitted anew elsewhere
  Tick confirmed_ = -1;                     ///< the newest confirmed tick, and since when
  Tick confirmed_at_ = 0;
  struct Asked {
    std::uint32_t incarnation = 0;
    Tick since = 0;
    bool spared = false;
  };
  /// Members that count as silent, as they did not let this peer in anew, or spared who was silent.
  std::map<PeerId, Asked> in_vain_;
  PublicKey differed_{};          ///< who has let this peer in anew though its hash differed
  Tick differed_until_ = 0;       ///< until when that counts
  PeerId asked_ = kNoPeer;        ///< the member by which this peer tries to join anew
  Tick back_since_ = 0;           ///< since when it has been trying that
  PeerId coordinates_ = kNoPeer;  ///< the coordinator, and since when it has been that
  Tick coordinates_since_ = 0;
  Tick alone_since_ = 0;  ///< since when it has left its seat and knows of nobody who lives
  bool told_ = false;
  bool misled_ = false;       ///< another member has lied to this one
  bool stands_down_ = false;  ///< it has left its seat to join anew
};

}  // namespace padr::node
