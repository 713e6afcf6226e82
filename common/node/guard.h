#pragma once

#include <array>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/node/recorded_node.h"
#include "common/node/session_desk.h"

namespace padr::node {

class Removals;

/// What a member may say, beyond what can be believed: orders are given by whom they are to give, every update was said
/// by whoever it is said to be of, and who keeps sending nonsense is not listened to.
///
/// Signatures and nonsense count only in a session with a key: in others anybody can speak in a member's name.
class Guard {
 public:
  explicit Guard(SessionDesk& desk) : desk_(desk), watches_(kMaxPeers) {}

  /// See Node::Judge.
  sync::DropReason judge(const sync::StatePacket& packet, const Node& node, const Removals& removals) const;
  /// Whether an update, and what it passes on, was said by whom it is said to be of, as far as we can tell: of who sat
  /// somewhere before we came we may know no key.
  bool said(const sync::Bundle& update, const Node& node) const;
  /// A datagram of p's was dropped.
  void on_drop(PeerId p, sync::DropReason why, RecordedNode& node, const Removals& removals, Micros local);
  /// Once a tick.
  void advance(RecordedNode& node, const Removals& removals);
  /// Whether somebody who asks to be let in has been cut off before, and not long enough ago.
  bool bars(const PublicKey& key, const Node& node) const;
  /// Keys of whom something is held against them; kMostOffenders at most.
  std::size_t offenders() const { return offenders_.size(); }
  /// Whether p is listened to.
  bool hears(PeerId p, const Node& node) const;

  static constexpr std::size_t kNonsense = 20;  ///< datagrams within kWithin and p is cut off
  static constexpr Tick kWithin = 10 * kTicksPerSecond;
  /// So long an order that p has no right to give may be tried again: what gives the right may be on its way here.
  static constexpr Tick kInsists = 4 * kTicksPerSecond;
  /// Whoever is heard, but keeps back for so long what it has promised, holds everybody's confirmed world up.
  static constexpr Tick kArrears = 8 * kTicksPerSecond;
  static constexpr Tick kBarred = 60 * kTicksPerSecond;  ///< who was in arrears; twice as long each time
  static constexpr std::size_t kMostOffenders = 64;
  static constexpr Tick kMuted = 2 * kTicksPerSecond;
  static constexpr Micros kTellAgain = 10 * kMicrosPerSecond;

 private:
  struct Watch {
    std::uint32_t incarnation = 0;
    /// The present series of orders it has no right to give: when it began, and the latest.
    struct Series {
      Tick since = 0;
      Tick last = 0;
    };
    std::optional<Series> unlawful;
    Tick deaf_until = -1;
    struct Told {
      std::uint64_t drops = 0;  ///< since the last word
      Micros at = std::numeric_limits<Micros>::min() / 2;
    };
    std::array<Told, sync::kDropReasons> told{};
  };
  /// Of a program, whatever slot it sits in, in whichever life.
  struct Offender {
    PublicKey key{};
    std::deque<Tick> nonsense;  ///< the latest, kNonsense at most
    Tick barred_until = 0;
    int times = 0;
  };
  Offender& offender(PeerId p, const Node& node);
  Watch& watch(PeerId p, const Node& node);
  bool is_too_much(PeerId p, sync::DropReason why, const Node& node);
  void bar(PeerId p, bool for_good, const Node& node);
  void tell(PeerId p, sync::DropReason why, Watch& w, Micros local);
  void cut_off(PeerId p, Watch& w, const std::string& why, RecordedNode& node, const Removals& removals);

  SessionDesk& desk_;
  std::vector<Watch> watches_;       ///< by slot
  std::vector<Offender> offenders_;  ///< kMostOffenders at most
};

/// Whether the updates that a transfer brings along were said by whom they are said to be of, as far as the transfer
/// tells who that is.
bool said(const sync::Transfer& transfer, std::uint16_t session);

}  // namespace padr::node
