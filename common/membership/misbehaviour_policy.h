#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/membership/last_heard.h"
#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"
#include "common/sync/packet.h"
#include "common/sync/transfer.h"
#include "common/sync/validation.h"

namespace padr::node {

class Evictions;

/// The rules for what a member may send, beyond the range of values: only the coordinator gives orders, every update is
/// signed by its peer, and a member that keeps sending invalid datagrams is cut off. An order that breaks a rule is
/// only dropped, and its member cut off for a while if nobody relays what would make it lawful: whether it is depends
/// on what the receiver knows, which a liar can arrange.
///
/// Signatures, and cut-offs for invalid datagrams, apply only in a session with a key; without one, anybody can send in
/// a member's name.
class MisbehaviourPolicy {
 public:
  explicit MisbehaviourPolicy(const SessionView& session) : session_(session), watches_(kMaxPeers) {}

  /// See Replica::Judge. Counts the signatures that it has to check.
  sync::DropReason judge(const sync::StatePacket& packet, PeerId relayed_by, const View& view,
                         const Evictions& evictions);
  /// Whether an update, and those that it passes on, have valid signatures, as far as this peer can tell: it may lack
  /// the keys of peers that left or were removed before it joined. Counts the signatures that member `by`, who shows
  /// the update, has it check; false if these are too many.
  bool said(PeerId by, const sync::Bundle& update, const View& view);
  /// A datagram of p was dropped.
  void on_drop(PeerId p, sync::DropReason why, const View& view, Micros local, Commands& out);
  /// Once a tick.
  void advance(const View& view, Commands& out);
  /// For how long a joiner with this key is still barred, ticks; 0: it is not, kForGood: for ever.
  Tick bars_for(const PublicKey& key, const View& view) const;
  bool bars(const PublicKey& key, const View& view) const { return bars_for(key, view) > 0; }
  /// Ends a joiner's first ban if it is for acknowledging nothing; for when another member tells of the joiner, or it
  /// is in anew. A peer that has cut off this one acknowledges nothing to it.
  void pardon(const PublicKey& key);
  /// Whether it is for ever.
  bool bars_for_good(const PublicKey& key) const;
  /// Keys with offences on record; kMostOffenders at most.
  std::size_t offenders() const { return offenders_.size(); }
  /// Whether datagrams of p are taken. The others relay the updates of a peer that is not heard.
  bool hears(PeerId p, const View& view) const;
  /// There is proof that p has lied: it is barred and cut off for good, whoever else hears it.
  void convict(PeerId p, const View& view, Commands& out);
  /// p has misled this peer by words that it cannot show to others.
  void distrust(PeerId p, const View& view, Commands& out);
  /// Takes over the bans of this peer's former incarnation, except for one that ends: who has let this peer in anew is
  /// followed by the others, and this peer could not follow them if it ignored that one.
  void inherit(const MisbehaviourPolicy& before, const PublicKey& let_in_by);

  static constexpr std::size_t kNonsense = 20;  ///< invalid datagrams within kWithin for which p is cut off
  static constexpr Tick kWithin = 10 * kTicksPerSecond;
  static constexpr Tick kBarred = 60 * kTicksPerSecond;  ///< first ban that ends; doubles each time
  /// Ban of whoever holds up everybody for the first time, ticks: it may have been its network.
  static constexpr Tick kBarredAtFirst = 10 * kTicksPerSecond;
  static constexpr Tick kForGood = std::numeric_limits<Tick>::max();
  /// Time for which a member that is heard may acknowledge no updates, ticks.
  static constexpr Tick kPatience = 2 * View::kArrears;
  /// The same for one that asks to be let in anew. All that it has not acknowledged must be kept meanwhile.
  static constexpr Tick kMostPatience = 4 * kPatience;
  /// Time for which a member that is heard again may owe what it could not tell before, ticks; kMostArrears in all.
  static constexpr Tick kBackFor = 2 * kTicksPerSecond;
  /// Time for which a drop of what a member had no right to say counts, ticks: what is repeated comes sooner.
  static constexpr Tick kUnlawful = 2 * kTicksPerSecond;
  /// Time for which a member's orders may be refused that nobody who has taken them relays, ticks.
  static constexpr Tick kRefused = 5 * kTicksPerSecond;
  static constexpr Tick kMostArrears = View::kArrears + kSilence;
  static constexpr std::size_t kMostOffenders = 64;
  /// Signatures of one member's updates that are checked per tick, and at most at once; and as many of those of others
  /// that it shows. An honest member makes one update a tick; after an outage of View::kArrears all of them come at
  /// once.
  static constexpr double kChecksPerTick = 4;
  static constexpr double kMostChecks = 2 * View::kArrears;
  static constexpr Micros kTellAgain = 10 * kMicrosPerSecond;

 private:
  struct Watch {
    std::uint32_t incarnation = 0;
    Tick deaf_until = -1;
    Tick unheard = -kBackFor;    ///< when it was last not heard
    Tick unlawful = -kUnlawful;  ///< when something was last dropped that it had no right to say
    Tick refused = -kUnlawful;   ///< likewise, of its updates the first that is missing
    /// Signatures that may be checked.
    struct Checks {
      double left = kMostChecks;
      Tick since = 0;
      bool take(int signatures, Tick now) {
        left = std::min(kMostChecks, left + kChecksPerTick * (now - since));
        since = now;
        if (signatures > left) return false;
        left -= signatures;
        return true;
      }
    };
    Checks own;
    Checks shown;  ///< of updates of lost peers
    struct Told {
      std::uint64_t drops = 0;  ///< since the last event
      Micros at = std::numeric_limits<Micros>::min() / 2;
    };
    std::array<Told, sync::kDropReasons> told{};
  };
  /// Offences of one key, in whatever slot and incarnation.
  struct Offender {
    PublicKey key{};
    std::deque<Tick> nonsense;  ///< the latest, kNonsense at most
    Tick barred_until = 0;
    int times = 0;
    bool warned = false;      ///< by a short ban
    bool pardonable = false;  ///< see pardon
  };
  bool is_heard(PeerId p, const View& view) const;
  Offender& offender(PeerId p, const View& view);
  Watch& watch(PeerId p, const View& view);
  bool may_check(const sync::StatePacket& packet, const View& view);
  bool said(const sync::Bundle& update, const View& view) const;
  bool is_refused(PeerId p, const View& view);
  bool is_too_much(PeerId p, const View& view);
  /// Whether it may be right to say what is dropped, by updates of a silent peer that are not here.
  bool may_lack_an_order(PeerId p, const View& view);
  enum class Ban : std::uint8_t { kAtFirst, kEnds, kForGood };
  Tick bar(PeerId p, Ban ban, const View& view);
  void tell(PeerId p, sync::DropReason why, Watch& w, Micros local, Commands& out);
  void cut_off(PeerId p, Ban ban, const std::string& why, const View& view, Commands& out);

  const SessionView& session_;
  std::vector<Watch> watches_;       ///< by slot
  std::vector<Offender> offenders_;  ///< kMostOffenders at most
};

}  // namespace padr::node
