#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/model/endpoint.h"
#include "common/sync/updates.h"

namespace padr::node {

enum class Presence : std::uint8_t {
  kAbsent,  ///< the slot is empty, or its peer has been removed
  kThere,
  kLeft,  ///< said goodbye; may linger until its last updates are acknowledged
};

/// A former occupant of a slot.
struct Former {
  std::uint32_t first = 0;  ///< number of its first update
  std::uint32_t incarnation = 0;
  Endpoint at;
};

/// The occupant of another slot of the session, and what has been heard of it. Times are ticks of the observer.
struct Seat {
  Presence presence = Presence::kAbsent;
  std::uint32_t incarnation = 0;  ///< of the present or last occupant
  std::uint32_t first = 0;        ///< number of its first update
  Endpoint at;
  std::vector<Former> former;  ///< the latest kFormer, eldest first

  Tick since = 0;                  ///< tick of its admission; of its first, if the transfer told of it
  Tick seated = 0;                 ///< when this peer learned of that admission
  Tick excused = 0;                ///< silence and arrears before this tick do not count
  Tick forgiven = 0;               ///< arrears before this tick do not count: something was in the way
  Tick acks_forgiven = 0;          ///< as forgiven, of acknowledgements
  Tick heard = 0;                  ///< when its last valid datagram came
  Tick answered = 0;               ///< when it last acknowledged something new of ours
  Tick answer_mark = -1;           ///< tick of its newest mark that has answered us
  Tick relayed = -1;               ///< tick of its newest update that came by relay only
  Tick given_up = -1;              ///< since when it counts as silent, whatever was heard before; -1: it does not
  bool given_up_for_good = false;  ///< even if others hear it
  bool proven = false;             ///< it has answered since silence was last excused
  Tick confirmed = 0;              ///< it has confirmed at least up to this tick
  Tick unacknowledged = -1;        ///< tick of our first update that it has not acknowledged; -1: it has all
  Tick same = -1;                  ///< the latest tick of which it has sent the hash that we have, too
  bool differs = false;            ///< it has sent a hash that differs from ours
  Tick differs_at = -1;            ///< the first tick of which it has
  Tick disputed = -1;              ///< when that was noticed
  bool frozen = false;             ///< its eviction is under way: nothing more is taken from it
  Tick answered_frozen = -1;       ///< when it last acknowledged something new of ours, while frozen
  Tick answers_since = -1;         ///< since when it has done so without longer pauses

  static constexpr std::size_t kFormer = 4;
  bool there() const { return presence == Presence::kThere; }
  /// Whether it is sent our datagrams, and its datagrams may still come.
  bool reachable() const { return presence != Presence::kAbsent; }
};

/// A peer was admitted, left or was removed, as far as this peer knows.
struct MemberChange {
  enum class Kind : std::uint8_t { kAdmitted, kLeft, kRemoved };
  Kind kind = Kind::kAdmitted;
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 0;
  Endpoint at;  ///< as it is to be reached from here; not set if not known
  Tick tick = 0;
  PeerId by = kNoPeer;  ///< the peer that published it
  Tick since = 0;       ///< tick of its admission
};

/// The occupants of a session's slots, as one peer knows them: a value. A Replica keeps it, and the membership rules
/// decide by it.
struct Roster {
  SessionId session{};
  PeerId self = kNoPeer;
  std::uint32_t incarnation = 0;  ///< of this peer in its slot
  Tick now = 0;
  bool member = false;   ///< this peer's avatar is, or was once, part of the session
  bool leaving = false;  ///< this peer has published that it leaves, or is about to
  Tick in_since = 0;     ///< tick of this peer's admission; its updates are of later ones
  Tick late = -1000;     ///< the last tick that this peer made far too late, as it had been held up
  /// Whose update that was, before it whose transfer this peer began with; kNoPeer: its own, or present from tick 0 on.
  PeerId admitted_by = kNoPeer;
  std::vector<Seat> seats;  ///< by slot; of the own one mainly `first` and `former` count

  PeerId slots() const { return static_cast<PeerId>(seats.size()); }
  /// Ticks since anything valid was heard of p; since the start if nothing was.
  Tick silence(PeerId p) const { return now - seats[p].heard; }
  /// Ticks since the last sign that p hears us, or that others hear p: since p last acknowledged something new of ours,
  /// or since the tick of its newest relayed update.
  Tick unanswered(PeerId p) const;
  /// Age of our first update that p has not acknowledged although it may well hear us, ticks; 0 if there is none.
  Tick unacknowledged(PeerId p) const;
  /// Whether p has left and then been silent for kDeparted: it has ended.
  bool departed(PeerId p) const { return seats[p].presence == Presence::kLeft && silence(p) > kDeparted; }
  std::uint32_t incarnation_of(PeerId p) const { return p == self ? incarnation : seats[p].incarnation; }
  /// Whether the occupant of slot a was admitted before that of slot b: incarnations grow from one admission to the
  /// next. Of two that were present at tick 0, the one in the lower slot counts as the first.
  bool is_senior(PeerId a, PeerId b) const { return std::pair(incarnation_of(a), a) < std::pair(incarnation_of(b), b); }
  /// The highest incarnation that this peer has heard of, its own included.
  std::uint32_t newest_incarnation() const;
  /// Address at that time of the peer that published the update; not set if it is unknown, or if it was this peer.
  Endpoint place_of_sayer(const sync::Bundle& said) const;

  /// p has acknowledged something new of ours, with a mark of tick `mark`.
  void note_answer(PeerId p, Tick mark);
  /// p counts as silent from now on, until it answers again. `for_good`: even if others hear it.
  void give_up(PeerId p, bool for_good);
  /// The eviction of p is under way, or is no longer. What p acknowledged meanwhile counts from now on.
  void freeze(PeerId p, bool frozen);
  /// p, which is frozen, has acknowledged something new of ours.
  void note_answer_of_frozen(PeerId p);
  /// This peer has been held up, and makes a tick late: that tick is no silence of the others.
  void excuse_tick();
  /// This peer has heard nobody up to now, as it has just come in.
  void excuse_silence();
  /// Gives slot p to another peer from that tick on, and remembers the former occupant.
  void seat(PeerId p, std::uint32_t as_incarnation, std::uint32_t first, const Endpoint& at, Tick from);

  /// Longest pause in which a frozen peer still counts as answering, ticks. It is sent a mark a second, and sends one a
  /// second, as nothing that the two say is acknowledged; some get lost.
  static constexpr Tick kAnswerPause = 3 * kTicksPerSecond;
  /// Silence after which a peer that has left counts as ended, ticks.
  static constexpr Tick kDeparted = 60;
};

/// The incarnation of an admitted peer exceeds the newest one by this at most: far more than honest coordinators need,
/// whose steps are random and below 128, with a joiner for every slot at once.
inline constexpr std::uint32_t kMostIncarnationStep = 1U << 14U;

/// Silence of a peer after which others are asked for its updates, until its silence reaches kRelayUntil; ticks. The
/// limit is there because all that it has not acknowledged must be kept meanwhile.
inline constexpr Tick kRelayAfter = 90;
inline constexpr Tick kRelayUntil = 5 * 60 * kTicksPerSecond;

}  // namespace padr::node
