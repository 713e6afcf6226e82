#pragma once

#include <array>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/membership/commands.h"
#include "common/membership/session_state.h"
#include "common/membership/view.h"
#include "common/sync/packet.h"
#include "common/sync/transfer.h"
#include "common/sync/validation.h"

namespace padr::node {

class Evictions;

/// The rules for what a member may send, beyond the range of values: only the coordinator gives orders, every update is
/// signed by its peer, and a member that keeps sending invalid datagrams is cut off.
///
/// Signatures, and cut-offs for invalid datagrams, apply only in a session with a key; without one, anybody can send in
/// a member's name.
class MisbehaviourPolicy {
 public:
  explicit MisbehaviourPolicy(const SessionView& session) : session_(session), watches_(kMaxPeers) {}

  /// See Replica::Judge.
  sync::DropReason judge(const sync::StatePacket& packet, const View& view, const Evictions& evictions) const;
  /// Whether an update, and those that it passes on, have valid signatures, as far as this peer can tell: it may lack
  /// the keys of peers that left or were removed before it joined.
  bool said(const sync::Bundle& update, const View& view) const;
  /// A datagram of p was dropped.
  void on_drop(PeerId p, sync::DropReason why, const View& view, const Evictions& evictions, Micros local,
               Commands& out);
  /// Once a tick.
  void advance(const View& view, const Evictions& evictions, Commands& out);
  /// Whether a joiner with this key is still barred.
  bool bars(const PublicKey& key, const View& view) const;
  /// Keys with offences on record; kMostOffenders at most.
  std::size_t offenders() const { return offenders_.size(); }
  /// Whether datagrams of p are taken.
  bool hears(PeerId p, const View& view) const;

  static constexpr std::size_t kNonsense = 20;  ///< invalid datagrams within kWithin for which p is cut off
  static constexpr Tick kWithin = 10 * kTicksPerSecond;
  /// Time for which p may repeat an order that it has no right to give: the update that gives the right may be late.
  static constexpr Tick kInsists = 4 * kTicksPerSecond;
  /// Time for which a member that is heard may withhold promised updates; they hold up every confirmed world.
  static constexpr Tick kArrears = 8 * kTicksPerSecond;
  static constexpr Tick kBarred = 60 * kTicksPerSecond;  ///< first ban for arrears; doubles each time
  static constexpr std::size_t kMostOffenders = 64;
  static constexpr Tick kMuted = 2 * kTicksPerSecond;
  static constexpr Micros kTellAgain = 10 * kMicrosPerSecond;

 private:
  struct Watch {
    std::uint32_t incarnation = 0;
    /// The present series of orders that it had no right to give: the first and the latest.
    struct Series {
      Tick since = 0;
      Tick last = 0;
    };
    std::optional<Series> unlawful;
    Tick deaf_until = -1;
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
  };
  Offender& offender(PeerId p, const View& view);
  Watch& watch(PeerId p, const View& view);
  bool is_too_much(PeerId p, sync::DropReason why, const View& view);
  void bar(PeerId p, bool for_good, const View& view);
  void tell(PeerId p, sync::DropReason why, Watch& w, Micros local, Commands& out);
  void cut_off(PeerId p, Watch& w, const std::string& why, const View& view, const Evictions& evictions, Commands& out);

  const SessionView& session_;
  std::vector<Watch> watches_;       ///< by slot
  std::vector<Offender> offenders_;  ///< kMostOffenders at most
};

/// Whether the updates in a transfer have valid signatures, as far as the transfer has the keys.
bool said(const sync::Transfer& transfer, std::uint16_t session);

}  // namespace padr::node
