#pragma once

#include <map>
#include <utility>

#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"

namespace padr::node {

class MisbehaviourPolicy;
class Relay;

/// Protects a peer that lives from an eviction by the word of the coordinator alone.
///
/// A member that hears a peer well does not follow a poll about it, and replies with the evidence: the newest updates
/// of the peer, which nobody else can sign. It asks the peer to publish one if it has none of the last seconds. Without
/// evidence it follows after kGrace: it may be mistaken, or lie.
class Vouching {
 public:
  explicit Vouching(const SessionView& session) : session_(session) {}

  /// Whether this member vouches for a peer of the poll. `due`: as in Evictions; `number`: of this peer's own polls.
  bool vouches(PeerId from, const wire::Poll& poll, const View& view, Tick due, std::uint32_t number,
               const MisbehaviourPolicy& misbehaviour, Relay& relay, Commands& out);
  /// Publishes an update if a member asks for one: a poll about this peer itself.
  void prove_alive(const wire::Poll& poll, const View& view, Commands& out);

  /// Time in which a peer that this member hears has to publish an update, ticks.
  static constexpr Tick kGrace = kTicksPerSecond;
  /// Between two requests for an update, ticks.
  static constexpr Tick kAskAgain = 20;
  /// Between two updates on request, ticks.
  static constexpr Tick kPace = 30;

 private:
  /// A peer that the member `from` polls about, although it is heard here.
  struct Doubted {
    std::uint32_t incarnation = 0;
    Tick since = 0;
    Tick last = 0;
    Tick asked = -kAskAgain;
  };
  bool vouches_for(const wire::Seat& s, PeerId from, const View& view, Tick due, std::uint32_t number, Relay& relay,
                   Commands& out);

  const SessionView& session_;
  std::map<std::pair<PeerId, PeerId>, Doubted> doubted_;  ///< by asker and slot
  Tick proved_ = -kPace;                                  ///< when this peer last published an update on request
};

}  // namespace padr::node
