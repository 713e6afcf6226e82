#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"
#include "common/sync/transfer.h"

namespace padr::node {

/// Finds peers that sign two different updates of one number, and makes that known; only in a session with a key.
///
/// Members whose confirmed worlds differ send each other the updates that they have of the ticks in which it may have
/// happened. Two updates of one peer that contradict each other prove that it lied: nobody else can sign them. A peer
/// that has such a proof sends it to all members, and a joiner gets it with its transfer.
class Testimony {
 public:
  using Proof = sync::Transfer::Proof;

  explicit Testimony(const SessionView& session) : session_(session) {}

  /// Member `from` has sent these updates of the peer in the slot. They are compared with those in the log.
  void on_updates(PeerId from, const wire::Fetched& sent, const View& view);
  /// The same of an update that `from` repeats.
  void on_repeat(const sync::Bundle& update, std::uint32_t incarnation, const View& view);
  /// Tells the peer at `to`, of another part of the session, of proofs against any of those who were evicted here: they
  /// may be with it. At most every kAgain.
  void tell(const Endpoint& to, const std::vector<sync::Transfer::Gone>& gone, const View& view, Commands& out);
  /// Keeps a proof if it is valid.
  void take(const Proof& proof);
  /// Once a tick.
  void advance(const View& view, Commands& out);

  /// kMostProofs at most, one for each key.
  const std::vector<Proof>& proofs() const { return proofs_; }
  /// Whether there is proof against the peer with this key.
  bool convicts(const PublicKey& key) const;
  /// A peer that had told this peer that all its updates up to a tick were here, and has signed another one. What has
  /// been confirmed here since may be wrong.
  std::optional<PeerId> misled_by() const { return misled_by_; }

  /// Between two datagrams of the same testimony or proof, ticks.
  static constexpr Tick kAgain = 15;
  /// Times that members whose worlds differ send each other what they have.
  static constexpr int kTimes = 4;
  /// Time for which members whose confirmed worlds differ look for the cause before one of them joins anew, ticks.
  static constexpr Tick kDispute = kTicksPerSecond;
  /// Time for which a proof is sent to the other members, ticks; a member that is away gets it when it joins anew.
  static constexpr Tick kMadeKnown = 20 * kTicksPerSecond;
  /// Pairs of contradicting updates of which the signatures are checked for each member, at once and each second.
  static constexpr int kMostChecks = 8;

 private:
  /// An update that could not be compared.
  struct Pending {
    std::uint32_t incarnation = 0;
    sync::Bundle update;
  };
  struct Dispute {
    std::uint32_t incarnation = 0;
    int times = 0;
    Tick next = 0;
  };
  struct Checks {
    Tick since = 0;
    int made = 0;
  };
  void compare(PeerId from, const sync::Bundle& update, std::uint32_t incarnation, const View& view);
  /// Whether it proves something of a key that is not convicted yet.
  bool is_new(const Proof& proof) const;
  /// Makes room for another proof, if the peer of one of them is not there.
  void forget_absent(const View& view);
  void accuse(PeerId from, std::uint32_t incarnation, const sync::Bundle& one, const sync::Bundle& other,
              const View& view);
  void note_broken_promise(PeerId from, const sync::Bundle& update, std::uint32_t incarnation, const View& view);
  bool may_check(PeerId from, const View& view);
  void testify(PeerId to, const View& view, Commands& out);
  void make_known(const View& view, Commands& out);

  const SessionView& session_;
  std::vector<Proof> proofs_;
  PublicKey known_{};  ///< of the convicted peer that is being made known; all zeros if none is there
  Tick since_ = 0;     ///< when that began
  Tick told_ = -kAgain;
  Tick told_outside_ = -kAgain;
  std::map<PeerId, Pending> pending_;   ///< by the member that sent it
  std::map<PeerId, Dispute> disputes_;  ///< by the member whose confirmed world differs
  std::map<PeerId, Checks> checks_;     ///< by the member that sent it
  std::optional<PeerId> misled_by_;
};

}  // namespace padr::node
