#pragma once

#include <map>
#include <utility>
#include <vector>

#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"

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

  /// Also from a coordinator that gathers what others have of a lost peer, which is frozen here.
  void on_fetch(PeerId from, const wire::Fetch& fetch, const View& view, Commands& out);
  void on_fetched(PeerId from, const wire::Fetched& fetched, const View& view, Commands& out);
  /// Once a tick.
  void advance(const View& view, Commands& out);
  /// Sends a member what it wants of another peer's updates, if they are here and it has not had its share yet.
  void serve(PeerId asker, const wire::Fetch& wanted, const View& view, Commands& out);
  /// Member `from` does not hear `about`. Returns for how long it has been saying so, ticks.
  Tick note_unheard(PeerId from, PeerId about, const View& view);
  /// Members that have lately asked for updates of `about`.
  PeerSet unheard_by(PeerId about, Tick now) const;
  /// Time after which a member that does not hear a peer may have it evicted, though others hear it; ticks. A little
  /// less than kRelayUntil, as it asks one member after the other.
  static constexpr Tick kUnheardForLong = kRelayUntil - 10 * kTicksPerSecond;

  static constexpr Tick kPace = 15;      ///< between two requests for one peer's updates, ticks
  static constexpr Tick kHurry = 6;      ///< until the next request after a reply, ticks
  static constexpr Tick kPatience = 60;  ///< a later reply is ignored, ticks
  static constexpr int kServed = 8;      ///< most replies to one member in kPace ticks
  /// A member that has not asked for this time hears the peer again, ticks. It asks the others in turn; and once it
  /// must ask no more it still waits for a while before it polls.
  static constexpr Tick kAsksOn = 15 * kTicksPerSecond;
  /// Time for which a member's question shows that it does not hear the peer, ticks. It asks all in turn, one each
  /// kPace.
  static constexpr Tick kAsksLately = 2 * kTicksPerSecond;

 private:
  struct Question {
    std::map<PeerId, Tick> asked;  ///< when each member that has not replied was asked last
    Tick next = 0;
  };
  struct Service {
    Tick since = -kPace;
    int times = 0;
  };
  /// Requests of one member about one peer that it does not hear.
  struct Unheard {
    Tick since = 0;
    Tick last = -kAsksOn;
  };
  PeerId next_to_ask(PeerId about, const View& view);

  const SessionView& session_;
  std::vector<Question> questions_;                       ///< by the peer that they are about
  std::vector<Service> services_;                         ///< by asker
  std::map<std::pair<PeerId, PeerId>, Unheard> unheard_;  ///< by asker and the peer that it is about
  int asked_last_ = 0;
};

}  // namespace padr::node
