#pragma once

#include <string>
#include <utility>

#include "common/replica/recorded_replica.h"
#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"

namespace padr::node {

inline View view_of(const Replica& replica) {
  return {replica.roster(), replica.agreed().log(), replica.live().world().scene()};
}

/// The only place where commands of a running session are carried out and recorded in the trace: at once and in order.
class AppliedCommands final : public Commands {
 public:
  /// Both must outlive it.
  AppliedCommands(SessionState& session, RecordedReplica& replica) : session_(session), replica_(replica) {}

  void send(const Endpoint& to, const wire::SessionMessage& message) override { session_.send(to, message); }
  void send(const Endpoint& to, const wire::MembershipMessage& message) override { session_.send(to, message); }
  std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) override {
    return session_.send_at_most(bytes, to, message);
  }
  bool may_answer(Micros local) override { return session_.may_answer(local); }
  void publish(const sync::Bundle& order) override { replica_.order(order); }
  void freeze(PeerId p, bool frozen) override { replica_.freeze(p, frozen); }
  void give_up(PeerId p, bool for_good) override { replica_.give_up(p, for_good); }
  void cut_off(PeerId p, const std::string& why) override { replica_.cut_off(p, why); }
  void relay(const wire::Fetched& updates, PeerId by) override { replica_.relay(updates, by); }
  void count_present(int members, int spectators) override {
    session_.present = members;
    session_.spectators = spectators;
  }
  void tell(SessionEvent event) override { session_.tell(std::move(event)); }

 private:
  SessionState& session_;
  RecordedReplica& replica_;
};

}  // namespace padr::node
