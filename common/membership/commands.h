#pragma once

#include <cstddef>
#include <string>

#include "common/membership/session_event.h"
#include "common/sync/updates.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::node {

/// What the rules of membership want done: a rule looks at the session and the View, and changes neither. In a session
/// each command is carried out at once; see AppliedCommands.
class Commands {
 public:
  Commands() = default;
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;
  virtual ~Commands() = default;

  virtual void send(const Endpoint& to, const wire::SessionMessage& message) = 0;
  virtual void send(const Endpoint& to, const wire::MembershipMessage& message) = 0;
  /// Sends it only if the datagram has at most so many bytes; returns its bytes, 0 if it was not sent.
  virtual std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) = 0;
  /// Whether anybody who asks may get one more answer now.
  virtual bool may_answer(Micros local) = 0;

  /// An order for the agreed world: an admission, removals, or an update of a lost peer.
  virtual void publish(const sync::Bundle& order) = 0;
  /// Takes no more updates from p, or takes them again.
  virtual void freeze(PeerId p, bool frozen) = 0;
  /// p counts as silent until it answers again.
  virtual void give_up(PeerId p, bool for_good) = 0;
  /// p is not listened to any more, or not for a while.
  virtual void cut_off(PeerId p, bool for_good, const std::string& why) = 0;
  /// Files updates that came by way of another member.
  virtual void relay(const wire::Fetched& updates) = 0;

  /// So many members are there, this one included.
  virtual void count_present(int members) = 0;
  virtual void tell(SessionEvent event) = 0;
};

}  // namespace padr::node
