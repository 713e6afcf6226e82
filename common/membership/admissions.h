#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"
#include "common/sync/transfer.h"

namespace padr::node {

/// Admits joiners to a running session, at the coordinator: gives each a slot, the agreed world and the time, and
/// publishes its admission once it has all of them.
class Admissions {
 public:
  explicit Admissions(const SessionView& session) : session_(session) {}

  void on_join(const Endpoint& from, const wire::Join& join, const View& view, Micros local, Commands& out);
  void on_ping(const Endpoint& from, const wire::Ping& ping, Micros local, Commands& out);
  /// Makes the transfer for a joiner.
  using TransferSource = std::function<sync::Transfer()>;
  void on_pull(const Endpoint& from, const wire::Pull& pull, const TransferSource& world, Micros local, Commands& out);
  /// `may_admit`: this peer is the coordinator, and no eviction is under way or near.
  void on_enter(const Endpoint& from, const wire::Enter& enter, const View& view, bool may_admit, Commands& out);
  /// Another peer is the coordinator now: redirects the joiner to it, unless it is admitted already.
  void pass_on(const Endpoint& from, const wire::Enter& enter, const Endpoint& coordinator, Commands& out);
  /// Time in which a joiner has to prove its address, us. A sender of invented addresses blocks a slot for no longer.
  static constexpr Micros kUnproven = 3 * kMicrosPerSecond;
  /// Most joiners that are given the world at the same time. Each admission is work for all members, so many joiners at
  /// once overload a slow machine unless they take turns.
  static constexpr std::ptrdiff_t kAtOnce = 4;
  /// Time after which a joiner no longer keeps other joiners waiting, us: it may have vanished, or be slow.
  static constexpr Micros kTurn = 2 * kMicrosPerSecond;

  /// Most times that all the pieces of a transfer are sent to one joiner in 8 s; three quarters of them may get lost.
  static constexpr std::size_t kMostTimes = 8;

  /// Forgets joiners whose time is up.
  void advance(Micros local);
  /// With a key: members that have asked to be let in anew, until some time after they are.
  PeerSet returning(const View& view) const;
  /// Joiners that are being admitted; at most one per slot.
  std::size_t guests() const { return guests_.size(); }

 private:
  struct Guest {
    Endpoint at;
    std::uint64_t nonce = 0;
    std::uint64_t cookie = 0;
    bool proven = false;  ///< it has received the cookie at its address
    PeerId slot = kNoPeer;
    std::uint32_t incarnation = 0;
    Micros since = 0;  ///< local time of its Join, then of each Pull until its turn begins
    std::vector<wire::Bytes> pieces;
    std::size_t sent = 0;             ///< pieces sent, each time counted, also to who joined from there a moment before
    Micros counted = 0;               ///< local time from which these are counted
    std::size_t most = 0;             ///< pieces of the longest transfer since then
    std::vector<std::uint32_t> have;  ///< by slot: with the pieces, the joiner has all updates below this
    bool ordered = false;
    bool spectator = false;
  };
  std::uint32_t incarnation_for(std::uint64_t nonce, const View& view) const;
  Guest* guest_at(const Endpoint& where, std::uint64_t nonce);
  std::uint64_t cookie_for(const Endpoint& where, std::uint64_t nonce) const;
  bool is_free(PeerId p, const Endpoint& joiner, const View& view) const;
  std::optional<PeerId> free_slot(const Endpoint& joiner, const View& view) const;
  bool knows_all_orders(const View& view) const;
  bool may_come_free(const View& view) const;
  Guest* take_in(const Endpoint& from, const wire::Join& join, const View& view, Micros local, Commands& out);
  std::vector<sync::Bundle> what_nobody_sends(const Guest& guest, const View& view) const;
  void refuse(const Endpoint& from, const wire::Join& join, const std::string& reason, Commands& out);

  const SessionView& session_;
  std::vector<Guest> guests_;
};

}  // namespace padr::node
