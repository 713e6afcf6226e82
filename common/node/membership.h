#pragma once

#include <map>
#include <optional>
#include <string>

#include "common/node/doorkeeper.h"
#include "common/node/guard.h"
#include "common/node/relay.h"
#include "common/node/removals.h"
#include "common/node/sides.h"

namespace padr::node {

/// A member's part in who is in a running session.
class Membership {
 public:
  /// Both must outlive it. The node's neighbours are where the desk's roster says.
  Membership(SessionDesk& desk, RecordedNode& node);

  void on_join(const Endpoint& from, const wire::Join& join, Micros local);
  /// False if it is not of a newcomer.
  bool on_ping(const Endpoint& from, const wire::Ping& ping, Micros local) {
    return doorkeeper_.on_ping(from, ping, local);
  }
  /// `bytes`: of the whole datagram.
  void receive(const Endpoint& from, const wire::Header& header, const wire::MembershipMessage& message,
               std::size_t bytes, Micros local);
  /// A state datagram from an address that nobody sits at, or of somebody who is out.
  void on_stranger(const Endpoint& from, std::size_t bytes, Micros local) {
    sides_.on_stranger(from, bytes, node_.node(), local);
  }
  /// Whether anything of a member is listened to.
  bool hears(PeerId p) const { return guard_.hears(p, node_.node()); }
  /// A state datagram of a member's was dropped.
  void on_drop(PeerId p, sync::DropReason why, Micros local) { guard_.on_drop(p, why, node_, removals_, local); }
  /// The machine at `at` says that nobody listens there.
  void on_unreachable(const Endpoint& at);
  /// Says once, there, who is in this session.
  void knock(const Endpoint& at) { sides_.knock(at, node_.node()); }
  /// Where somebody was in another life of this peer's.
  void remember(const Endpoint& at) { sides_.remember(at, node_.node().now()); }
  /// Once a tick, after the node's step.
  void advance(Micros local);
  /// Whom to join anew because this peer is out, or has another world than the rest; nothing if all is well.
  std::optional<Endpoint> way_back() const;
  /// Says, once, that this peer takes that way, and why.
  void announce_way_back();
  PeerId coordinator() const { return removals_.coordinator(node_.node()); }
  /// Coming and going, since the last call, in words of `changes`.
  std::vector<MemberChange> take_changes();

 private:
  std::optional<PeerId> sender(const Endpoint& from, const wire::Header& header) const;
  void follow_changes();
  void note_former_lives(const std::vector<MemberChange>& changes);
  void end_former_lives();
  /// Somebody is about to be declared gone.
  bool doubts() const;
  void watch_confirmed();
  bool stuck() const;
  std::string why_back() const;

  SessionDesk& desk_;
  RecordedNode& node_;
  Doorkeeper doorkeeper_;
  Removals removals_;
  Relay relay_;
  Guard guard_;
  Sides sides_;
  std::vector<MemberChange> changes_;
  std::map<PeerId, Tick> refused_;          ///< since when nobody listens where it was
  std::map<PeerId, std::uint32_t> former_;  ///< slots and incarnations of lives that are over
  Tick confirmed_ = -1;                     ///< the tick confirmed here, and since when
  Tick confirmed_at_ = 0;
  bool told_ = false;
};

}  // namespace padr::node
