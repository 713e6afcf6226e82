#pragma once

#include <string>

#include "common/membership/session_state.h"
#include "common/replica/recorded_replica.h"

namespace padr::node {

/// What the rules of membership want done. Here alone it is done, and recorded in the trace, at once and in order: a
/// rule looks at the session and the replica, and changes neither.
class Commands {
 public:
  /// Both must outlive it.
  Commands(SessionState& session, RecordedReplica& replica) : session_(session), replica_(replica) {}

  void send(const Endpoint& to, const wire::SessionMessage& message) { session_.send(to, message); }
  void send(const Endpoint& to, const wire::MembershipMessage& message) { session_.send(to, message); }
  /// Sends it only if the datagram has at most so many bytes; returns its bytes, 0 if it was not sent.
  std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) {
    return session_.send_at_most(bytes, to, message);
  }
  /// Whether anybody who asks may get one more answer now.
  bool may_answer(Micros local) { return session_.may_answer(local); }

  /// An order for the agreed world: an admission, removals, or an update of a lost peer.
  void publish(const sync::Bundle& order) { replica_.order(order); }
  /// Takes no more updates from p, or takes them again.
  void freeze(PeerId p, bool frozen) { replica_.freeze(p, frozen); }
  /// p counts as silent until it answers again.
  void give_up(PeerId p, bool for_good) { replica_.give_up(p, for_good); }
  /// p is not listened to any more, or not for a while.
  void cut_off(PeerId p, bool for_good, const std::string& why) { replica_.cut_off(p, for_good, why); }
  /// Files updates that came by way of another member.
  void relay(const wire::Fetched& updates) { replica_.relay(updates); }

  /// So many members are there, this one included.
  void count_present(int members) { session_.present = members; }
  void tell(SessionEvent event) { session_.tell(std::move(event)); }

 private:
  SessionState& session_;
  RecordedReplica& replica_;
};

}  // namespace padr::node
