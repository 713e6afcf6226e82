#pragma once

#include <string>

#include "common/membership/session_state.h"

namespace padr::node {

/// Everybody else's part of a session: asks a member, is passed on to the founder, agrees on its clock, waits for the
/// start.
class Joiner {
 public:
  Joiner(SessionState& session, Micros local);

  /// Somebody else wants to join, and asks us.
  void on_join(const Endpoint& from, const wire::Join& join, Micros local);
  void on_welcome(const Endpoint& from, const wire::Header& header, const wire::Welcome& welcome, Micros local);
  void on_redirect(const Endpoint& from, const wire::Redirect& redirect, Micros local);
  void on_refuse(const Endpoint& from, const wire::Refuse& refuse);
  void on_pong(const Endpoint& from, const wire::Pong& pong, Micros local);
  void on_start(const Endpoint& from, const wire::Start& start, Micros local);
  void on_bye(const Endpoint& from, const wire::Bye& bye);
  /// Whoever is there speaks another version of the protocol.
  void on_other_version(const Endpoint& from, int version);
  /// The machine at `at` says that nobody listens there.
  void on_unreachable(const Endpoint& at, Micros local);
  void advance(Micros local);
  void leave(const std::string& reason);
  Micros round_trip() const { return offset_.round_trip(); }
  std::uint64_t nonce() const { return nonce_; }

 private:
  void ask(Micros local);
  bool is_target(const Endpoint& from);
  void start_over_if_unheard(Micros local);
  void ping(Micros local);
  /// Whether everybody's address is known now.
  bool take_members(const wire::Start& start);
  bool agreed() const { return offset_.samples() >= SessionPace::kSamples; }
  void give_up_if_late(Micros local);

  SessionState& session_;
  std::uint64_t nonce_;
  Endpoint target_;  ///< whom we ask; the founder once we are in
  int redirects_ = 0;
  Micros redirected_ = 0;
  Micros asked_ = 0;
  Micros pinged_ = 0;
  Micros heard_ = 0;  ///< of the founder, last
  Micros tick0_ = 0;  ///< by the founder's clock
  OffsetEstimator offset_;
  wire::Roster told_;  ///< by the Starts so far; who is not set is still missing
};

}  // namespace padr::node
