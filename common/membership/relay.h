#pragma once

#include <vector>

#include "common/membership/commands.h"
#include "common/membership/session_state.h"
#include "common/membership/view.h"

namespace padr::node {

/// Relays updates between two members that do not hear each other while others hear both.
///
/// A member that does not hear a peer, or lacks updates that the peer does not repeat, asks the others in turn, and
/// they send what they have. In a session with a key every update is signed, so a relayed update proves that its peer
/// was alive at its tick and that no earlier update is missing; the confirmed world goes on with it. Only members are
/// served, at a bounded rate. No peer is relayed for longer than kRelayUntil, because both must keep their
/// updates until they are acknowledged.
class Relay {
 public:
  explicit Relay(const SessionView& session);

  void on_fetch(PeerId from, const wire::Fetch& fetch, const View& view, Commands& out);
  void on_fetched(PeerId from, const wire::Fetched& fetched, const View& view, Commands& out);
  /// Once a tick.
  void advance(const View& view, Commands& out);

  static constexpr Tick kPace = 15;      ///< between two requests for one peer's updates, ticks
  static constexpr Tick kHurry = 6;      ///< until the next request after a reply, ticks
  static constexpr Tick kPatience = 60;  ///< a later reply is ignored, ticks
  static constexpr int kServed = 8;      ///< most replies to one peer in kPace ticks

 private:
  struct Question {
    PeerId to = kNoPeer;
    Tick at = -kPace;
    Tick next = 0;
  };
  struct Service {
    Tick since = -kPace;
    int times = 0;
  };
  PeerId next_to_ask(PeerId about, const View& view);

  const SessionView& session_;
  std::vector<Question> questions_;  ///< by the peer that they are about
  std::vector<Service> services_;    ///< by asker
  int asked_last_ = 0;
};

}  // namespace padr::node
