#pragma once

#include <vector>

#include "common/node/recorded_node.h"
#include "common/node/session_desk.h"

namespace padr::node {

/// How two members go on that do not hear one another while others hear both.
///
/// Whoever does not hear a member, or has missed what it does not repeat, asks the others in turn for its updates, and
/// they send what they have, as they do of a lost peer's. In a session with a key every update is signed, so a relayed
/// one proves that its peer was alive at its tick, and that no earlier update is missing: confirmed goes on with it,
/// whoever relays. Only members are served, and only so much; and nobody is relayed for longer than Node::kRelayUntil,
/// as what the two tell one another has to be kept until they have acknowledged it.
class Relay {
 public:
  explicit Relay(SessionDesk& desk);

  void on_fetch(PeerId from, const wire::Fetch& fetch, const Node& node);
  void on_fetched(PeerId from, const wire::Fetched& fetched, RecordedNode& node);
  /// Once a tick.
  void advance(const Node& node);

  static constexpr Tick kPace = 15;      ///< between two questions for one peer's updates
  static constexpr Tick kHurry = 6;      ///< after an answer: there may be more
  static constexpr Tick kPatience = 60;  ///< a later answer is not taken
  static constexpr int kServed = 8;      ///< answers to one peer in kPace ticks at most

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
  PeerId next_to_ask(PeerId about, const Node& node);

  SessionDesk& desk_;
  std::vector<Question> questions_;  ///< by whom they are about
  std::vector<Service> services_;    ///< by asker
  int asked_last_ = 0;
};

}  // namespace padr::node
