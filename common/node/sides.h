#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/node/removals.h"

namespace padr::node {

/// What happens when those who have declared one another gone meet again.
///
/// Each side goes on knocking at the addresses of those it lost. When a knock gets through, the side with more living
/// peers wins, of two alike the one with the lowest slot, or the eldest in it; whoever is on the losing side joins the
/// winning one anew, and takes over its world.
class Sides {
 public:
  explicit Sides(SessionDesk& desk) : desk_(desk) {}

  void on_change(const MemberChange& change);
  void on_probe(const Endpoint& from, PeerId sender, const wire::Probe& probe, std::size_t bytes, const Node& node,
                Micros local);
  /// A state datagram of this session has come from nobody who is in it.
  void on_stranger(const Endpoint& from, std::size_t bytes, const Node& node, Micros local);
  /// Once, at an address that is no member's.
  void knock(const Endpoint& at, const Node& node);
  /// Once a tick.
  void advance(const Node& node);

  /// Knocks there, too.
  void remember(const Endpoint& at, Tick now);
  std::vector<Endpoint> gone() const;
  /// Of a winning side that has been heard of lately, to join anew.
  std::optional<Endpoint> winner(const Node& node) const;

  static constexpr Tick kPace = kTicksPerSecond / 3;
  static constexpr Tick kGrace = kTicksPerSecond;
  static constexpr Tick kLately = 2 * kTicksPerSecond;
  static constexpr Tick kRemember = 20 * 60 * kTicksPerSecond;
  static constexpr std::size_t kMost = sync::Transfer::kMostGone;

 private:
  struct Gone {
    Endpoint at;
    Tick since = 0;
  };
  /// Bytes that a stranger has sent and not got back.
  struct Credit {
    Endpoint at;
    std::size_t bytes = 0;
  };
  using Side = std::vector<wire::Seat>;
  bool member_at(const Endpoint& where, const Node& node) const;
  Side ours(const Node& node) const;
  void send_probe(const Endpoint& to, bool knows, const Node& node);
  /// Takes back what is about to be sent to a stranger who has just sent so many bytes, if that is more than it sent.
  void hold_back_beyond(const Endpoint& to, std::size_t bytes);

  SessionDesk& desk_;
  std::vector<Gone> gone_;
  std::vector<Credit> credits_;                  ///< kMost at most
  std::map<PeerId, std::uint32_t> disowned_by_;  ///< and their incarnations
  std::optional<Endpoint> winner_;
  Tick probed_ = 0;
  Tick won_at_ = 0;
};

}  // namespace padr::node
