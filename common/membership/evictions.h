#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/membership/last_heard.h"
#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"

namespace padr::node {

class MisbehaviourPolicy;

/// Evicts peers that fall silent, so that no confirmed world ever has to be taken back.
///
/// The coordinator is the most senior living peer. It asks all peers that it hears when they heard the silent peer
/// last; a peer that a member hears stays (see last_heard.h). Then it asks how many of the lost peer's updates they
/// have. A member that replies takes no more updates from the lost peer, so the highest reply is the end of its log.
/// The coordinator publishes in its own log the updates that a member lacks, and then the removal, with the number of
/// the last update, at its present tick. These are delivered and repeated like any update. If the coordinator is lost
/// meanwhile, the next one evicts both. If a member hears the peer again and does not follow the poll, the coordinator
/// takes back its poll about that peer: polls are numbered, and one with a higher number cancels those before it. About
/// other lost peers it polls anew.
class Evictions {
 public:
  explicit Evictions(const SessionView& session) : session_(session) {}

  /// `due`: the tick at which this peer would be, had it not been held up. `vouched`: this peer vouches for one of the
  /// peers that it is about, and so does not follow.
  void on_poll(PeerId from, const wire::Poll& poll, const View& view, Tick due, bool vouched, Commands& out);
  void on_answer(PeerId from, const wire::Answer& answer, const View& view, Commands& out);
  /// Updates of a lost peer; if they are new, they prove that it lives.
  void on_fetched(PeerId from, const wire::Fetched& fetched, const View& view, MisbehaviourPolicy& misbehaviour,
                  Commands& out);
  /// Once a tick.
  void advance(const View& view, Commands& out);

  /// The most senior peer that is alive, as far as this peer can tell.
  PeerId coordinator(const View& view) const { return first_of(view, 0); }
  /// The same without some.
  PeerId first_of(const View& view, PeerSet without) const;
  /// Number of this peer's polls.
  std::uint32_t number() const { return number_; }
  /// Whether p has given no sign of life for kSilence, direct or relayed.
  static bool suspected(const View& view, PeerId p) { return view.roster.unanswered(p) >= kSilence; }
  /// Polls of the peer in the slot no longer count: it has lied, or another one has the slot.
  void forget_asker(PeerId slot) {
    forget_answers(slot);
    numbers_.erase(slot);
  }
  /// Members that are heard but, for kWithheld, have not replied to a poll, not sent an update that they claim to have,
  /// or claimed to lack one that all have. The eviction goes on without them.
  std::vector<PeerId> withholding(const View& view) const;
  /// Whether none of two or more members has followed this peer's polls in kWithheld: they follow another one, and
  /// would not take its order. One member alone may be lying.
  bool is_forsaken() const { return forsaken_; }
  /// Whether for kWithheld all other members have had an update of a lost peer in the states that they began with,
  /// which nobody can send. Later ones of that peer show that there is one, so they have confirmed what this peer
  /// cannot.
  bool is_behind() const { return behind_; }
  bool busy() const { return !lost_.empty(); }
  /// Whether this peer has replied to a poll of `by` about the peer in the slot: then `by` may evict that peer.
  bool answered(PeerId by, PeerId slot) const { return answered_.contains({by, slot}); }
  bool answered(PeerId by, PeerId slot, std::uint32_t incarnation) const {
    const auto it = answered_.find({by, slot});
    return it != answered_.end() && it->second.incarnation == incarnation;
  }

  static constexpr Tick kAskAgain = 6;
  /// Time for which this peer must hear a peer that it has frozen to ask for it back, ticks.
  static constexpr Tick kHeardAgain = kTicksPerSecond;
  /// Time in which an asker has to take its poll back then, or to poll again, ticks; only in a session with a key. Also
  /// the time after its last poll with a number from which polls with a lower number count again.
  static constexpr Tick kLease = 2 * kTicksPerSecond;
  /// Timeout for poll replies: worst honest delay plus margin. An honest peer may stand still for almost kSilence, wait
  /// kSilence more until it misses the lost peer itself, and then reply over a bad link. Shorter than the time after
  /// which members join anew because nothing is confirmed.
  static constexpr Tick kWithheld = 2 * kSilence + 90;
  /// Timeout for an update that a member claims to have. Each who has it is asked several times a second; a member that
  /// has confirmed a later tick without it, as a liar promised, keeps none.
  static constexpr Tick kUnsent = kSilence + kTicksPerSecond;
  /// The same for a member that has asked to be let in anew: if it hears this peer, it replies within a few round
  /// trips.
  static constexpr Tick kReturning = kSilence / 2;

 private:
  struct Lost {
    std::uint32_t incarnation = 0;
    std::map<PeerId, std::uint32_t> have;           ///< updates that each member has, by its reply
    std::map<std::uint32_t, sync::Bundle> fetched;  ///< by number; not in the log, which is frozen
    /// The first from here on that is not in `fetched`.
    std::uint32_t next(std::uint32_t from) const {
      for (auto it = fetched.lower_bound(from); it != fetched.end() && it->first == from; ++it) ++from;
      return from;
    }
    std::uint32_t least = 0;  ///< every member has the updates below this
    std::uint32_t most = 0;   ///< no member has updates from this on
    bool ordered = false;
    std::size_t fetches = 0;
    LastHeard grounds;             ///< what was known when it was frozen
    std::map<PeerId, Tick> asked;  ///< since when each member's reply is awaited; not in it: since the peer was frozen
    std::map<PeerId, Tick> hears;  ///< by member that does not follow: tick at which it heard the peer last; -1: never
  };
  /// That this peer has frozen a peer for an asker.
  struct Answered {
    std::uint32_t incarnation = 0;
    Tick polled = 0;      ///< when the asker last polled about it
    Tick contested = -1;  ///< since when this peer replies that it hears it again; -1: it does not
  };
  /// The newest number of an asker's polls, and the tick of the last poll with it.
  struct Numbered {
    std::uint32_t number = 0;
    Tick polled = 0;
  };
  /// An update that a member lacks and that is not here.
  struct Missing {
    PeerId of = kNoPeer;
    std::uint32_t index = 0;
  };
  bool is_to_blame(PeerId p, const Missing& missing, const View& view) const;
  bool is_lacking(const View& view) const;
  bool is_silent(PeerId p, const View& view) const;
  /// Whether `from` may evict peers, as far as this peer can tell.
  bool follows(PeerId from, const wire::Poll& poll, const View& view, Tick due) const;
  void forget_answers(PeerId asker) {
    std::erase_if(answered_, [asker](const auto& entry) { return entry.first.first == asker; });
  }
  static bool hears_again(PeerId p, const View& view);
  bool is_current(PeerId from, std::uint32_t number, Tick now);
  bool contests(PeerId from, const wire::Poll& poll, const View& view);
  bool has_expired(PeerId asker, const Answered& a, const View& view) const;
  /// Time in which this peer catches up is none in which an asker does not poll.
  void excuse_askers(const View& view);
  void thaw(const View& view, Commands& out);
  void keep(PeerId from, const wire::Fetched& fetched, Lost& lost, const View& view, MisbehaviourPolicy& misbehaviour);
  bool lives(PeerId p, const Lost& lost, const View& view) const;
  void go_on_without(const View& view, Commands& out);
  bool is_forsaken_by(const std::vector<PeerId>& who, const View& view) const;
  bool is_vetoed(PeerId p, const Lost& lost, const View& view) const;
  void take_back(PeerSet who, const View& view, Commands& out);
  void take_back_if_over(const View& view, Commands& out);
  void tell_taken_back(const View& view, Commands& out);
  void doubt(const View& view, Commands& out);
  bool is_first_well(const View& view) const;
  LastHeard hearsay(PeerId p, const View& view) const;
  bool waits_for_others(PeerId p, const View& view) const;
  void notice(const View& view, Commands& out);
  bool counts(PeerId p, const View& view) const;
  bool all_answered(const View& view) const;
  void ask(const View& view, Commands& out);
  void poll(const wire::Poll& poll, const View& view, Commands& out);
  bool ordered() const;
  bool gather(PeerId p, Lost& lost, const View& view, Commands& out);
  void fetch(PeerId p, Lost& lost, std::uint32_t index, const View& view, Commands& out);
  void bury(Commands& out);

  /// A silent peer, and the ticks at which other members heard it last.
  struct Doubted {
    std::uint32_t incarnation = 0;
    std::map<PeerId, Tick> heard;
    bool told = false;  ///< the event kHeard has been sent
  };

  const SessionView& session_;
  std::map<PeerId, Doubted> doubted_;
  Tick doubts_asked_ = 0;
  std::map<PeerId, Lost> lost_;         ///< as the coordinator
  std::set<PeerId> withholds_;          ///< members whose replies do not count for these
  std::uint32_t number_ = 0;            ///< of this peer's polls; the next with each that is taken back
  std::vector<wire::Seat> taken_back_;  ///< the peers of the poll that was taken back last
  Tick taken_back_at_ = 0;              ///< when that was
  std::set<PeerId> unaware_;            ///< members that may not know yet that it is taken back
  Tick told_ = 0;                       ///< when they were last sent a poll with the new number
  std::map<PeerId, Numbered> numbers_;  ///< by asker
  std::map<std::pair<PeerId, PeerId>, Answered> answered_;  ///< by asker and slot
  Tick polled_ = 0;
  Tick asked_ = 0;
  Tick moved_ = 0;                  ///< tick of the last progress: a reply, a fetched update, or one more lost peer
  std::optional<Missing> missing_;  ///< the update that is being fetched
  bool forsaken_ = false;
  bool behind_ = false;
};

}  // namespace padr::node
