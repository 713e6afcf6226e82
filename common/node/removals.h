#pragma once

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/node/hearsay.h"
#include "common/node/recorded_node.h"
#include "common/node/session_desk.h"

namespace padr::node {

class Guard;

/// How those who fall silent are declared gone, so that nobody's confirmed world ever has to be taken back.
///
/// The coordinator, the lowest living peer, asks all whom it hears when they heard the silent one last: whom anybody
/// hears is not lost (see hearsay.h). Then it asks how many of the lost peer's updates they have. Who answers takes
/// nothing more from the lost one, so the longest answer is the end of its log. What anybody lacks of that the
/// coordinator passes on in its own log, and then the removal with the end's number, at its present tick. All of it is
/// delivered and repeated like any update. If the coordinator is lost meanwhile, the next one does it for both.
class Removals {
 public:
  explicit Removals(SessionDesk& desk) : desk_(desk) {}

  void on_poll(PeerId from, const wire::Poll& poll, RecordedNode& node);
  void on_answer(PeerId from, const wire::Answer& answer, const Node& node);
  void on_fetch(PeerId from, const wire::Fetch& fetch, const Node& node);
  void on_fetched(const wire::Fetched& fetched, const Node& node, const Guard& guard);
  /// Once a tick.
  void advance(RecordedNode& node);

  /// The lowest peer that lives as far as this one can tell.
  PeerId coordinator(const Node& node) const;
  /// Silent, one way or the other, for too long.
  static bool suspected(const Node& node, PeerId p) { return node.unanswered(p) >= kSilence; }
  /// Somebody else sits in the slot: what who sat there has asked does not count for it.
  void forget_asker(PeerId slot) {
    std::erase_if(answered_, [slot](const auto& entry) { return entry.first.first == slot; });
  }
  /// Who is heard, but for kWithheld has not said what it has of the lost, or not sent what it says it has: nobody can
  /// be declared gone as long as that counts.
  std::vector<PeerId> withholding(const Node& node) const;
  bool busy() const { return !lost_.empty(); }
  /// This peer has told `by` what it has of who sits, or sat, in the slot: `by` may declare that one gone.
  bool answered(PeerId by, PeerId slot) const { return answered_.contains({by, slot}); }
  bool answered(PeerId by, PeerId slot, std::uint32_t incarnation) const {
    const auto it = answered_.find({by, slot});
    return it != answered_.end() && it->second == incarnation;
  }

  static constexpr Tick kAskAgain = 6;
  /// Longer than an honest peer takes that was held up for almost kSilence, then waits as long before it, too, misses
  /// the lost, and answers over a bad link; shorter than it takes the others to come in anew since nothing is
  /// confirmed.
  static constexpr Tick kWithheld = 2 * kSilence + 90;

 private:
  struct Lost {
    std::uint32_t incarnation = 0;
    std::map<PeerId, std::uint32_t> have;           ///< by who has answered
    std::map<std::uint32_t, sync::Bundle> fetched;  ///< by number
    std::uint32_t least = 0;                        ///< somebody has no more than the updates below this
    std::uint32_t most = 0;                         ///< nobody has any beyond these
    bool ordered = false;
    std::size_t fetches = 0;
  };
  /// Whether `from` is the one to declare somebody gone, as far as this peer can tell.
  bool follows(PeerId from, const wire::Poll& poll, const Node& node) const;
  void thaw(RecordedNode& node);
  void doubt(const Node& node);
  bool is_first_well(const Node& node) const;
  Hearsay hearsay(PeerId p, const Node& node) const;
  void notice(RecordedNode& node);
  bool counts(PeerId p, const Node& node) const;
  bool all_answered(const Node& node) const;
  void ask(const Node& node);
  void poll(const wire::Poll& poll, const Node& node);
  bool ordered() const;
  bool gather(PeerId p, Lost& lost, const Node& node);
  void fetch(PeerId p, Lost& lost, std::uint32_t index, const Node& node);
  void bury(RecordedNode& node);

  /// A peer that does not answer, and when others have heard it.
  struct Doubted {
    std::uint32_t incarnation = 0;
    std::map<PeerId, Tick> heard;
    bool told = false;  ///< that it stays
  };

  SessionDesk& desk_;
  std::map<PeerId, Doubted> doubted_;
  Tick doubts_asked_ = 0;
  std::map<PeerId, Lost> lost_;                                  ///< as the coordinator
  std::map<std::pair<PeerId, PeerId>, std::uint32_t> answered_;  ///< by asker and slot: the latest incarnation
  std::map<PeerId, PeerId> frozen_for_;                          ///< as one who has answered: whom for
  Tick asked_ = 0;
  Tick moved_ = 0;  ///< when something new of the lost came last, or somebody more was lost
  struct Missing {
    PeerId of = kNoPeer;
    std::uint32_t index = 0;
  };
  std::optional<Missing> missing_;  ///< what is asked for now
};

}  // namespace padr::node
