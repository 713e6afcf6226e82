#pragma once

#include <vector>

#include "common/session/commands.h"
#include "common/session/session_state.h"

namespace padr::node {

/// Introduces newcomers to the coordinator, which may be behind a NAT that lets in only answers, or out of their reach.
///
/// A member that redirects a newcomer tells the coordinator of it, so that both send something to the other at once:
/// this opens most NATs. In a session with a key the member also carries between the two for kLease. By then the
/// newcomer is a member, or asks anew.
class Introductions {
 public:
  explicit Introductions(const SessionView& session) : session_(session) {}

  struct Introduction {
    Endpoint newcomer;
    Endpoint other;  ///< at the member that redirects: the coordinator; at the coordinator: that member
    Micros since = 0;
  };

  /// Sends the newcomer at `from`, which wants to join, to the coordinator.
  void redirect(const Endpoint& from, const wire::Join& join, const Endpoint& coordinator, Micros local, Commands& out);
  /// The member at `by` has redirected a newcomer to this peer, the coordinator.
  void on_newcomer(const Endpoint& by, const wire::Newcomer& newcomer, Micros local, Commands& out);
  /// Whether one of the two is a newcomer that this peer has redirected to the other one.
  bool may_carry(const Endpoint& from, const Endpoint& to) const;
  /// At the coordinator, in a session with a key: newcomers that others have redirected to it.
  const std::vector<Introduction>& introduced() const { return introduced_; }
  /// Forgets those whose time is up.
  void advance(Micros local);

  static constexpr Micros kLease = 10 * kMicrosPerSecond;
  /// Newcomers that are remembered; the latest.
  static constexpr std::size_t kMost = 64;

 private:
  static void note(std::vector<Introduction>& all, const Introduction& one);

  const SessionView& session_;
  std::vector<Introduction> redirected_;
  std::vector<Introduction> introduced_;
};

}  // namespace padr::node
