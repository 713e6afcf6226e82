#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/membership/evictions.h"
#include "common/sync/transfer.h"

namespace padr::node {

/// Merges the two parts of a session after a partition, in which each part evicted the other.
///
/// Each part goes on sending Probes to the addresses of the peers that it lost. When a Probe arrives, the part with
/// more living peers wins; of two alike, the part with the lowest slot, or the lowest incarnation in it. The peers of
/// the other part join the winner anew and take over its world.
///
/// A Probe lists the peers of a part, and a single liar could list any. So in a session with a key a list only says who
/// belongs together. Each listed peer counts only if it has sent a Probe lately itself, and its key was a member's that
/// this part evicted, or that left: it may have found others than those who stayed. Peers that the other part cannot
/// know do not count on either side: those that were admitted after the eviction, or shortly before. Of two parts with
/// equally many the one with the most senior of these peers wins; of two with one each only if it is not the smaller
/// one.
///
/// All that two parts know of each other may be a peer that was a member of both, and it may end. So with its Probes
/// each part tells of its own peers, in turn. A peer that has been alone for kAlone looks for those peers as well.
class PartitionMerge {
 public:
  /// The living peers of one part, by slot.
  using Side = std::vector<wire::Seat>;
  /// Whether a part of the same session outranks another one: nobody is in both, and it has more peers, or as many and
  /// the lowest slot, or the lower incarnation in it.
  static bool outranks(const Side& a, const Side& b);

  explicit PartitionMerge(const SessionView& session) : session_(session) {}

  void on_change(const MemberChange& change, const View& view);
  void on_probe(const Endpoint& from, PeerId sender, const wire::Probe& probe, std::size_t bytes, const View& view,
                Micros local, Commands& out);
  /// A Probe of a peer that this one has barred for a while: it is followed nowhere, but counts in its part, as there.
  void on_probe_of_barred(const Endpoint& from, PeerId sender, const wire::Probe& probe, const View& view);
  /// A state datagram of this session has come from an address of no member.
  void on_stranger(const Endpoint& from, std::size_t bytes, const View& view, Micros local, Commands& out);
  /// A peer of another part has told of one of its part.
  void on_told(const Endpoint& from, const Endpoint& of, const View& view);
  /// Whether nothing has been confirmed here for kStalled: then seniority keeps no part of the same size from winning.
  void set_stalled(bool stalled) { stalled_ = stalled; }
  /// This peer stands still, or has just made a tick more than kSilence late: what its part did meanwhile is nothing.
  void note_sleep(Tick now) { slept_ = now; }
  /// Sends one Probe to an address of no member.
  void knock(const Endpoint& at, const View& view, Commands& out);
  /// Once a tick.
  void advance(const View& view, Commands& out);

  /// Sends Probes to those whom this peer's former incarnation knew, too, from now on.
  void inherit(const PartitionMerge& before, const View& then, Tick now);
  /// Sends Probes to this evicted peer, too, from now on.
  void remember(const sync::Transfer::Gone& gone, Tick now);
  std::vector<sync::Transfer::Gone> gone() const;
  /// Whether this peer has had nobody else in its part for a while.
  bool is_alone(const View& view) const { return is_lonely(kGrace, view); }
  /// Whether the address is another member's, or an evicted peer's that Probes are sent to.
  bool knows(const Endpoint& at, const View& view) const;
  /// Tick at which the peer in slot p was first admitted to the session, in whatever slot.
  Tick since(PeerId p, const View& view) const;
  /// Address of a winning part that was heard lately, to join it anew.
  std::optional<Endpoint> winner(const View& view) const;
  /// How many Joins may go to a winner's address now, which count as sent; absent: any number.
  std::optional<int> joins_for(const Endpoint& at, const View& view);

  static constexpr Tick kPace = kTicksPerSecond / 3;
  /// Least time between two Probes in reply to one peer, ticks: each of its Probes is replied to, but not its replies.
  static constexpr Tick kAnswerPace = kPace / 2;
  static constexpr Tick kGrace = kTicksPerSecond;
  static constexpr Tick kLately = 2 * kTicksPerSecond;
  /// Time for which lost peers are looked for often, ticks; without a key they are then forgotten.
  static constexpr Tick kRemember = 20 * 60 * kTicksPerSecond;
  /// Time between two Probes to one of them after that, ticks: an outage may last for hours.
  static constexpr Tick kRarely = 30 * kTicksPerSecond;
  /// A peer that was admitted within this time before an eviction may be unknown to the evicted peer: the longest time
  /// from a partition to the eviction.
  static constexpr Tick kMayBeUnknown = kSilence + Evictions::kWithheld;
  /// Time after which a part is believed of which this peer knows no more than where its peers are, ticks.
  static constexpr Tick kStrangers = 10 * kTicksPerSecond;
  /// The same for a peer that is alone, if it knows but one of that part, or has only been told of that part. With the
  /// time in which it loses the others and that of coming in anew it has to be back within 30 s.
  static constexpr Tick kAlone = 15 * kTicksPerSecond;
  /// Time after which a peer that is alone yields though its part is not the smaller one, ticks.
  static constexpr Tick kLonely = 3 * kAlone;
  /// Time for which a peer tries to join the winner, and then stays, ticks; twice as long if the winner itself yields.
  static constexpr Tick kInVain = 10 * kTicksPerSecond;
  /// Time for which a peer that is alone then stays, ticks. Longer than another one takes to come in.
  static constexpr Tick kStaysAlone = 3 * kTicksPerSecond;
  /// After it has stood still, a peer yields to a part that is no smaller for this time, ticks, and sends no Probes for
  /// kLately: the others, who were awake, look for it.
  static constexpr Tick kDrowsy = 10 * kTicksPerSecond;
  /// Shorter than the time after which this peer would join its own part anew, ticks.
  static constexpr Tick kStalled = 10 * kTicksPerSecond;
  /// Time between two peers of the own part that a peer of another part is told of, ticks, after the first ones.
  static constexpr Tick kTell = 2 * kTicksPerSecond;
  /// Peers of other parts that are remembered as told; the latest.
  static constexpr std::size_t kMostTold = 8;
  static constexpr std::size_t kMost = sync::Transfer::kMostGone;

 private:
  using Gone = sync::Transfer::Gone;
  static constexpr Tick kNever = std::numeric_limits<Tick>::max();
  struct Remembered {
    Gone gone;
    Tick kept = 0;          ///< when it was remembered
    bool has_left = false;  ///< by itself, or somebody else is at its place: it is not looked for
    bool told = false;      ///< of members of our part
    PeerId next = 0;        ///< the one of whom it was told last
    Tick before = kNever;   ///< its first admission, as a former incarnation of this peer knew it
  };
  /// A peer of another part, by a Probe of its own.
  struct Witness {
    Endpoint from;
    PeerId slot = kNoPeer;
    std::uint32_t incarnation = 0;
    Tick heard = 0;
    Tick answered = -kAnswerPace;  ///< when it was last sent a Probe in reply
    Side members{};                ///< by its last Probe
  };
  /// The peers of a part that the other part knows.
  struct Weight {
    std::size_t peers = 0;
    Tick senior = kNever;  ///< first admission of the most senior of them
    void add(Tick since) {
      ++peers;
      senior = std::min(senior, since);
    }
  };
  struct Weights {
    Weight theirs;
    Weight ours;
    std::size_t peers() const { return theirs.peers + ours.peers; }
  };
  /// An address of no member, and the bytes that it has sent beyond those it received.
  struct Credit {
    Endpoint at;
    std::size_t bytes = 0;
  };
  /// A peer of which somebody of another part has told.
  struct Told {
    Endpoint at;
    Tick since = 0;
  };
  void keep_gone(const Remembered& r);
  /// Nobody else is looked for where a member is.
  void note_member_at(const Endpoint& place);
  bool member_at(const Endpoint& where, const View& view) const;
  /// Whether the occupant of slot p has said by a Probe that this peer is no member.
  bool disowns_us(PeerId p, const View& view) const;
  /// Whether the peer in slot p is another one of our part.
  bool is_ours(PeerId p, const View& view) const;
  bool has_company(const View& view) const;
  /// Whether this peer has had nobody else in its part for that time, ticks.
  bool is_lonely(Tick time, const View& view) const { return view.roster.now - had_company_ >= time; }
  /// What this peer knows of it, for evidence.
  Gone known(const Remembered& r, const View& view) const;
  /// Whether a peer with this key was a member here, or is one.
  bool has_been_here(const PublicKey& key, const View& view) const;
  /// Whether the peer is known to have been a member here. That it was seen elsewhere is no evidence.
  static bool was_member(const Gone& g) { return g.since < g.removed; }
  /// Whether this peer itself sent the Probe from this address, with this slot and incarnation.
  bool is_own(const Endpoint& from, PeerId sender, std::uint32_t incarnation, const View& view) const;
  void tell_of_ours(Remembered& to, const View& view, Commands& out);
  Side ours(const View& view) const;
  /// Whether this peer has stood still, and been up to date again for less than that time, ticks.
  bool is_awake_for_less(Tick time, const View& view) const { return view.roster.now - slept_ < kSilence + time; }
  /// Whether this part has slept through what the other one, which is no smaller, has done.
  bool has_slept_through(const wire::Probe& probe, const View& view) const;
  Witness& note_witness(const Endpoint& from, PeerId sender, const wire::Probe& probe, Tick now);
  static bool lists(const Side& side, const Witness& w);
  /// Whether others of that part have spoken, and none of them says that the Probe's sender is one of them.
  bool is_disowned(const Witness& sender, Tick now) const;
  std::vector<Gone> evidence(const Side& side, const View& view) const;
  /// Whether a part has more peers than another one, or as many and the lowest slot, or the lower incarnation in it.
  static bool comes_first(const Side& a, const Side& b);
  /// Whether nobody is in both parts, as far as the other part's list and the keys of its witnesses tell.
  bool is_disjoint(const Side& theirs, const Side& us, const View& view) const;
  /// Whether a Probe of the larger part has come lately.
  bool is_outvoted(const View& view) const;
  bool is_outranked(const wire::Probe& probe, const Side& us, const View& view) const;
  /// Whether the peer at `from` is one of those members for whom there is evidence.
  bool is_witness(const Endpoint& from, const wire::Probe& probe, const View& view) const;
  /// With a key: whether more, or more senior, witnesses are in that part, of those that both parts can know.
  bool has_stronger_evidence(const wire::Probe& probe, const Side& us, const View& view) const;
  /// When this part evicted the first of them that was a member; kNever if none was.
  static Tick split_from(const std::vector<Gone>& witnesses);
  /// Whether it has more witnesses than this part has peers that count (`own`); or as many, nobody is in both, and its
  /// list comes first.
  bool is_larger(const wire::Probe& probe, const Side& us, std::size_t witnesses, std::size_t own,
                 const View& view) const;
  /// Whether it has been so for kStrangers.
  bool is_larger_for_long(const wire::Probe& probe, const Side& us, const View& view);
  /// Stops trying to join the winner for a while, if this peer has tried for long.
  void give_winner_up(const View& view);
  wire::Probe our_probe(bool knows, const View& view) const;
  /// Whether anybody could have named this address as its own: no member has been there, and the session has no key.
  bool is_unproven(const Endpoint& at, const View& view) const;
  Credit& credit_of(const Endpoint& at);
  /// Sends a Probe in reply; without a key, only if it is no larger than what that address has sent so far.
  void reply_within_credit(const Endpoint& to, const View& view, Commands& out);

  const SessionView& session_;
  std::vector<Remembered> gone_;
  std::vector<Gone> returned_;                   ///< those that were admitted anew, once each; the latest kMost
  std::vector<Witness> witnesses_;               ///< kMost at most
  std::vector<Told> told_;                       ///< kMostTold at most
  PublicKey own_key_{};                          ///< by the order that admitted this peer
  std::vector<Credit> credits_;                  ///< kMost at most
  std::map<PeerId, std::uint32_t> disowned_by_;  ///< members whose Probes disown us, and their incarnations
  std::optional<Endpoint> winner_;
  bool winner_yields_ = false;  ///< by its latest Probe
  bool stalled_ = false;
  Tick probed_ = 0;
  Tick told_at_ = -kTell;
  Tick had_company_ = kNever;  ///< when somebody else was last in this part
  Tick won_at_ = 0;
  Tick yields_since_ = 0;
  Tick stays_until_ = 0;  ///< no part wins before
  Tick slept_ = -kSilence - kDrowsy;
  Tick larger_since_ = 0;  ///< since when Probes of a larger part have come
  Tick larger_seen_ = -kLately;
};

}  // namespace padr::node
