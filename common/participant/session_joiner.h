#pragma once

#include "common/membership/session_state.h"

namespace padr::node {

/// The first part of coming into a session: asks a member to be let in, is passed on to the coordinator, and is
/// welcomed or refused.
class Joiner {
 public:
  Joiner(SessionState& session, Micros local);

  /// Somebody else wants to join, and asks us.
  void on_join(const Endpoint& from, const wire::Join& join, Micros local);
  void on_welcome(const Endpoint& from, const wire::Header& header, const wire::Welcome& welcome);
  void on_redirect(const Endpoint& from, const wire::Redirect& redirect, Micros local);
  void on_refuse(const Endpoint& from, const wire::Refuse& refuse);
  /// Whoever is there speaks another version of the protocol.
  void on_other_version(const Endpoint& from, int version);
  /// The machine at `at` says that nobody listens there.
  void on_unreachable(const Endpoint& at, Micros local);
  void advance(Micros local);

 private:
  void ask(Micros local);
  bool is_target(const Endpoint& from);
  void start_over_if_unheard(Micros local);
  void give_up_if_late(Micros local);

  SessionState& session_;
  std::uint64_t nonce_;
  Endpoint target_;  ///< whom we ask
  int redirects_ = 0;
  Micros redirected_ = 0;
  Micros asked_ = 0;
};

}  // namespace padr::node
