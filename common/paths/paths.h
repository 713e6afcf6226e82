#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/replica/roster.h"
#include "common/wire/membership_codec.h"

namespace padr::node {

/// Decides by which way each member is reached: directly, or through another member that both reach. One hop, no more.
///
/// A link works in one direction and may not in the other. So it is the receiver who says so: a member tells those that
/// it does not hear directly, and those for whom others carry, whom it does hear, and how long that takes. Somebody
/// from whom nothing has been heard of all this is reached through one member after the other until it answers.
class Paths {
 public:
  /// What is measured of the link to the member in a slot.
  struct Link {
    Tick unanswered = 0;  ///< since the member last acknowledged something new of ours, by whatever way, ticks
    float delay = 0;      ///< one way, ticks
    PeerSet unheard = 0;  ///< of a silent member: who has asked this one for its updates lately, and so lacks them, too
  };
  /// `to` has been reached through `by` for kReported and has answered; kNoPeer: directly again.
  struct Change {
    PeerId to = kNoPeer;
    PeerId by = kNoPeer;
    friend bool operator==(const Change&, const Change&) = default;
  };

  /// Something of the member has come directly.
  void note_direct(PeerId from, Tick now);
  void on_reach(PeerId from, const wire::Reach& reach, Tick now);
  /// Once a tick. `links`: by slot.
  std::vector<Change> advance(const Roster& roster, const std::vector<Link>& links);
  struct Telling {
    wire::Reach reach;
    PeerSet to = 0;
  };
  /// What this member now has to tell those whose link does not work, or did not until a moment ago.
  std::optional<Telling> due(const Roster& roster, const std::vector<Link>& links);
  /// kNoPeer: it is reached directly.
  PeerId carrier(PeerId of) const { return ways_[of].by; }

  /// Whether a member has lately told whom it hears. Until then nobody knows whether its own link would do, so what is
  /// carried for it is sent directly, too.
  bool has_told(PeerId p, Tick now) const { return has_told(ways_[p], now); }

  /// Whoever carries between this peer and another member sees that one there.
  void note_seen(PeerId who, const Endpoint& where);
  /// Where else a member may be: its own addresses, as it says, and where a carrier has seen it last.
  std::vector<Endpoint> addresses(PeerId of) const;

  /// A member of which nothing has come directly for this time is not heard directly, ticks. More than the longest
  /// honest interval between two datagrams, of which one may get lost.
  static constexpr Tick kUnheard = 75;
  /// A carrier fails if its member says for this time that it does not hear this one, ticks: longer than until it does
  /// so and says so. If it says nothing, one of the two waits twice as long for an acknowledgement, and the other four
  /// times.
  static constexpr Tick kUnanswered = 120;
  /// What a member has told of whom it hears counts for this time, ticks.
  static constexpr Tick kFresh = 3 * kTicksPerSecond;
  /// Between two times of telling it while it lasts, ticks; and so often afterwards.
  static constexpr Tick kTellAgain = 30;
  static constexpr int kTellAfterwards = 4;
  /// A carrier by which a member did not answer comes after all others for this time, ticks; and for twice that each
  /// time it happens again, so many times.
  static constexpr Tick kFailed = 30 * kTicksPerSecond;
  static constexpr int kMostDoublings = 6;
  /// A carrier that lasts for so long is worth a word, ticks.
  static constexpr Tick kReported = 2 * kTicksPerSecond;
  /// Another carrier has to save this much, ticks.
  static constexpr float kBetter = 3;
  /// A direct way that fails within kRelapse is left alone for kStay, and for twice that the next time, until kLongest.
  static constexpr Tick kRelapse = 10 * kTicksPerSecond;
  static constexpr Tick kStay = 2 * kTicksPerSecond;
  static constexpr Tick kLongest = 60 * kTicksPerSecond;

 private:
  struct Failure {
    std::uint32_t incarnation = 0;  ///< of the carrier
    Tick until = 0;
    int times = 0;
  };
  struct Way {
    bool known = false;
    std::uint32_t incarnation = 0;
    Tick direct = 0;            ///< when something of it came directly
    PeerId by = kNoPeer;        ///< its carrier
    Tick since = 0;             ///< since when
    PeerId reported = kNoPeer;  ///< the carrier in the last Change
    Tick stay = 0;              ///< for how long at least
    Tick told_at = -kFresh;
    Tick told_tick = -1;                    ///< of the sender
    std::map<PeerId, std::uint32_t> hears;  ///< whom it hears directly, and their delay in ticks
    PeerSet hears_carried = 0;              ///< whom it hears only by others
    std::vector<Endpoint> at;               ///< its own addresses
    std::optional<Endpoint> seen;           ///< by whoever carries for it
    std::map<PeerId, Failure> failed;       ///< by carrier
    void fail(std::uint32_t incarnation, Tick now);
    bool has_failed(PeerId carrier, std::uint32_t incarnation, Tick now) const;
  };
  bool has_told(const Way& w, Tick now) const { return now - w.told_at < kFresh; }
  static Tick unanswered(const Roster& roster, const std::vector<Link>& links, PeerId p);
  bool hears(const Roster& roster, PeerId p) const;
  bool needs_carrier(const Roster& roster, const std::vector<Link>& links, PeerId p) const;
  std::optional<float> cost(const Roster& roster, const std::vector<Link>& links, PeerId p, PeerId by) const;
  bool leads_nowhere(const Roster& roster, const std::vector<Link>& links, PeerId p) const;
  PeerId choose(const Roster& roster, const std::vector<Link>& links, PeerId p) const;
  void change(Way& w, PeerId by, Tick now);

  std::array<Way, kMaxPeers> ways_;
  PeerSet heard_ = 0;      ///< directly, as told last
  PeerSet carried_ = 0;    ///< only by others, as told last
  PeerSet concerned_ = 0;  ///< who is told
  int left_to_tell_ = 0;   ///< times
  Tick told_ = -kTellAgain;
};

}  // namespace padr::node
