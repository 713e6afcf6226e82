#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/model/endpoint.h"
#include "common/sync/updates.h"

namespace padr::node {

enum class Presence : std::uint8_t {
  kAbsent,  ///< nobody sits in the slot, or who did has been declared gone
  kThere,
  kLeft,  ///< has said goodbye, and may linger to get its last words across
};

/// Who sat in a slot before who sits there now.
struct Former {
  std::uint32_t first = 0;  ///< number of its first update
  std::uint32_t incarnation = 0;
  Endpoint at;
};

/// Who sits in another slot of the session, and what has been heard of it. Times are ticks of the observer.
struct Seat {
  Presence presence = Presence::kAbsent;
  std::uint32_t incarnation = 0;  ///< of who sits or sat there last
  std::uint32_t first = 0;        ///< number of its first update
  Endpoint at;
  std::vector<Former> former;  ///< the latest kFormer, eldest first

  Tick since = 0;                  ///< tick of its admission
  Tick excused = 0;                ///< nothing before this is held against it
  Tick heard = 0;                  ///< when anything valid came last
  Tick answered = 0;               ///< when it last said that it got something new of ours
  Tick answer_mark = -1;           ///< of its newest mark that has answered us
  Tick relayed = -1;               ///< of its newest update that has come by somebody else only
  Tick given_up = -1;              ///< since when it counts as silent, whatever was heard before; -1: it does not
  bool given_up_for_good = false;  ///< whoever hears it
  bool proven = false;             ///< it has answered since silence was last excused
  Tick confirmed = 0;              ///< it has confirmed so far at least
  Tick unacknowledged = -1;        ///< tick of our first update that it has not acknowledged; -1: it has all
  bool differs = false;            ///< it has told a hash that is not ours
  bool frozen = false;             ///< being declared gone: nothing more is taken from it

  static constexpr std::size_t kFormer = 4;
  bool there() const { return presence == Presence::kThere; }
  /// Whether it gets our datagrams and we may get some of it.
  bool reachable() const { return presence != Presence::kAbsent; }
};

/// Somebody has come or gone, as far as is known here.
struct MemberChange {
  enum class Kind : std::uint8_t { kAdmitted, kLeft, kRemoved };
  Kind kind = Kind::kAdmitted;
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 0;
  Endpoint at;  ///< as it is to be reached from here; not set if not known
  Tick tick = 0;
  PeerId by = kNoPeer;  ///< who said so
};

/// Who is where in a session, as one peer knows it: a value. A Replica keeps it, and the rules of membership decide by
/// it.
struct Roster {
  std::uint16_t session = 0;
  PeerId self = kNoPeer;
  std::uint32_t incarnation = 0;  ///< of this peer in its slot
  Tick now = 0;
  bool member = false;           ///< this peer's avatar is, or was once, part of the session
  bool leaving = false;          ///< this peer has said goodbye, or will with its next step
  Tick in_since = 0;             ///< tick of this peer's admission; its updates are of later ones
  PeerId admitted_by = kNoPeer;  ///< whose update that was; kNoPeer: its own, as it was there from tick 0 on
  std::vector<Seat> seats;       ///< by slot; the own one is only a place

  PeerId slots() const { return static_cast<PeerId>(seats.size()); }
  /// Ticks since anything valid was heard of p; since the start if nothing was.
  Tick silence(PeerId p) const { return now - seats[p].heard; }
  /// Ticks since the last sign that p hears us, or that others hear p: since p last said that it had got something new
  /// of ours, or the tick of its newest update that was relayed.
  Tick unanswered(PeerId p) const;
  /// How old the first update of ours is that p, which may well hear us, has not acknowledged; ticks.
  Tick unacknowledged(PeerId p) const;
  /// A peer that has left and been silent since has ended.
  bool departed(PeerId p) const { return seats[p].presence == Presence::kLeft && silence(p) > kDeparted; }
  /// The highest incarnation that this peer has heard of, its own included.
  std::uint32_t newest_incarnation() const;
  /// Where who said the update was then; not set if that is not known, or if it was this peer.
  Endpoint place_of_sayer(const sync::Bundle& said) const;

  /// p has said, with a mark of that tick, that it got something new of ours.
  void note_answer(PeerId p, Tick mark);
  /// Counts as silent from now on, until it answers again. `for_good`: it does not matter whether others hear it.
  void give_up(PeerId p, bool for_good);
  /// This peer was held up: nobody can be blamed for not having been heard meanwhile.
  void excuse_silence();
  /// Another peer sits there from that tick on; who sat there before is remembered.
  void seat(PeerId p, std::uint32_t as_incarnation, std::uint32_t first, const Endpoint& at, Tick from);

  /// Who has left and been silent for this long has ended.
  static constexpr Tick kDeparted = 60;
};

/// Who has not been heard for so long is asked for by others' having it, and no longer than kRelayUntil: what is kept
/// for it meanwhile is not told as received.
inline constexpr Tick kRelayAfter = 90;
inline constexpr Tick kRelayUntil = 5 * 60 * kTicksPerSecond;

}  // namespace padr::node
