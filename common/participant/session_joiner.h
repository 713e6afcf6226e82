#pragma once

#include <optional>
#include <string>

#include "common/session/session_state.h"

namespace padr::node {

/// The first part of joining a session: asks a member for a slot, or several in turn, is redirected to the coordinator,
/// and is welcomed or refused.
class Joiner {
 public:
  Joiner(SessionState& session, Micros local);

  /// Another joiner asks us.
  void on_join(const Endpoint& from, const wire::Join& join, Micros local);
  void on_welcome(const Endpoint& from, const wire::Header& header, const wire::Welcome& welcome);
  void on_redirect(const Endpoint& from, const wire::Redirect& redirect, Micros local);
  void on_refuse(const Endpoint& from, const wire::Refuse& refuse, Micros local);
  /// The peer at `from` has another version of the protocol.
  void on_other_version(const Endpoint& from, int version);
  /// The machine at `at` reports that nobody listens there.
  void on_unreachable(const Endpoint& at, Micros local);
  void advance(Micros local);

  /// A member that has redirected this peer carries between it and the coordinator.
  struct Introduction {
    Endpoint to;      ///< the coordinator
    Endpoint by;      ///< the member
    Micros from = 0;  ///< local time before which the coordinator is only asked directly
  };
  std::optional<Introduction> introduction(Micros local) const;

 private:
  void ask(Micros local);
  const Endpoint& contact(std::size_t turn) const;
  void ask_next_if_unheard();
  bool is_target(const Endpoint& from);
  void start_over_if_unheard(Micros local);
  void give_up_if_late(Micros local);
  void tell_why_it_takes_long(Micros local);
  /// Why this peer is not in after so long, us.
  std::string why_not_in(Micros after, Micros local) const;

  SessionState& session_;
  std::uint64_t nonce_;
  Endpoint target_;                           ///< the peer that we ask
  std::size_t turn_ = 0;                      ///< contacts that were given up
  std::optional<Introduction> introduction_;  ///< the last one
  int redirects_ = 0;
  Micros redirected_ = 0;
  Micros asked_ = 0;
  int asks_ = 0;       ///< of the present target
  int joins_ = 0;      ///< of all targets
  int passed_on_ = 0;  ///< times that a redirect was worth a Join of its own, if they are limited
  struct Refused {
    Endpoint at;
    Micros when = 0;
  };
  std::optional<Refused> refused_;  ///< the last report that nobody listens there
  std::string full_;                ///< the refusal of a session that was full
  Micros full_since_ = 0;
  Micros told_;  ///< when it was last told why this takes long
};

}  // namespace padr::node
