#pragma once

#include <optional>
#include <vector>

#include "common/node/recorded_node.h"
#include "common/node/session_desk.h"

namespace padr::node {

/// The coordinator's part in letting newcomers into a running session: gives them a slot, the agreed world and the
/// time, and publishes their admission when they have all of it.
class Doorkeeper {
 public:
  explicit Doorkeeper(SessionDesk& desk) : desk_(desk) {}

  void on_join(const Endpoint& from, const wire::Join& join, const RecordedNode& node, Micros local);
  bool on_ping(const Endpoint& from, const wire::Ping& ping, Micros local);
  /// `gone`: see sync::Transfer.
  void on_pull(const Endpoint& from, const wire::Pull& pull, const RecordedNode& node, std::vector<Endpoint> gone);
  /// `may_admit`: nothing else about who is there is being decided.
  void on_enter(const Endpoint& from, const wire::Enter& enter, RecordedNode& node, bool may_admit);
  /// Somebody else is the coordinator by now: who has not been admitted yet is to ask there.
  void pass_on(const Endpoint& from, const wire::Enter& enter, const Endpoint& coordinator);
  /// Forgets those who have not come in.
  void advance(Micros local);
  /// Who is being let in: one a slot at most.
  std::size_t guests() const { return guests_.size(); }

 private:
  struct Guest {
    Endpoint at;
    std::uint64_t nonce = 0;
    std::uint64_t cookie = 0;
    bool proven = false;  ///< has got the cookie where it says that it is
    PeerId slot = kNoPeer;
    std::uint32_t incarnation = 0;
    Micros since = 0;
    std::vector<wire::Bytes> pieces;
    std::vector<std::uint32_t> have;  ///< with the pieces
    bool ordered = false;
  };
  Guest* guest_at(const Endpoint& where, std::uint64_t nonce);
  std::uint64_t cookie_for(const Endpoint& where, std::uint64_t nonce) const;
  bool is_free(PeerId p, const Node& node) const;
  std::optional<PeerId> free_slot(const Node& node) const;
  bool knows_all_orders(const Node& node) const;
  bool may_come_free(const Node& node) const;
  Guest* take_in(const Endpoint& from, const wire::Join& join, const Node& node, Micros local);
  void pass_on_what_nobody_sends(const Guest& guest, RecordedNode& node);
  void refuse(const Endpoint& from, const wire::Join& join, const std::string& reason);

  SessionDesk& desk_;
  std::vector<Guest> guests_;
};

}  // namespace padr::node
