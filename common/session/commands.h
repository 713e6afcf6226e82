#pragma once

#include <cstddef>
#include <string>

#include "common/session/session_event.h"
#include "common/sync/updates.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::node {

/// The commands of the membership rules. A rule reads the session and the View, and changes neither. In a session each
/// command is carried out at once; see AppliedCommands.
class Commands {
 public:
  Commands() = default;
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;
  virtual ~Commands() = default;

  virtual void send(const Endpoint& to, const wire::SessionMessage& message) = 0;
  virtual void send(const Endpoint& to, const wire::MembershipMessage& message) = 0;
  /// Sends the message only if its datagram has at most `bytes` bytes. Returns the datagram's bytes, 0 if not sent.
  virtual std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) = 0;
  /// Whether the rate limit allows one more reply now; if so, it is counted.
  virtual bool may_answer(Micros local) = 0;

  /// An order for the agreed world: an admission, removals, or an update of a lost peer.
  virtual void publish(const sync::Bundle& order) = 0;
  /// Stops taking updates from p, or resumes.
  virtual void freeze(PeerId p, bool frozen) = 0;
  /// p counts as silent until it answers again; `for_good`: even if others hear it.
  virtual void give_up(PeerId p, bool for_good) = 0;
  /// Datagrams of p are ignored from now on, and p counts as silent until others relay its updates.
  virtual void cut_off(PeerId p, const std::string& why) = 0;
  /// Files updates that member `by` relayed.
  virtual void relay(const wire::Fetched& updates, PeerId by) = 0;

  /// Sets the number of members present, this one included, and of the spectators among them.
  virtual void count_present(int members, int spectators) = 0;
  virtual void tell(SessionEvent event) = 0;
};

}  // namespace padr::node
