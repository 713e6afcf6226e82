#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/membership/evictions.h"
#include "common/sync/transfer.h"

namespace padr::node {

/// Merges the two parts of a session after a partition, in which each part evicted the other.
///
/// Each part goes on sending Probes to the addresses of the peers that it lost. When a Probe arrives, the part with
/// more living peers wins; of two alike, the part with the lowest slot, or the lowest incarnation in it. The peers of
/// the other part join the winner anew and take over its world.
class PartitionMerge {
 public:
  /// The living peers of one part, by slot.
  using Side = std::vector<wire::Seat>;
  /// Whether a part of the same session outranks another one: nobody is in both, and it has more peers, or as many and
  /// the lowest slot, or the lower incarnation in it.
  static bool outranks(const Side& a, const Side& b);

  explicit PartitionMerge(const SessionView& session) : session_(session) {}

  void on_change(const MemberChange& change);
  void on_probe(const Endpoint& from, PeerId sender, const wire::Probe& probe, std::size_t bytes, const View& view,
                Micros local, Commands& out);
  /// A state datagram of this session has come from an address of no member.
  void on_stranger(const Endpoint& from, std::size_t bytes, const View& view, Micros local, Commands& out);
  /// Sends one Probe to an address of no member.
  void knock(const Endpoint& at, const View& view, Commands& out);
  /// Once a tick.
  void advance(const View& view, Commands& out);

  /// Sends Probes to `at`, too, from now on.
  void remember(const Endpoint& at, Tick now);
  std::vector<Endpoint> gone() const;
  /// Address of a winning part that was heard lately, to join it anew.
  std::optional<Endpoint> winner(const View& view) const;

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
  /// An address of no member, and the bytes that it has sent beyond those it received.
  struct Credit {
    Endpoint at;
    std::size_t bytes = 0;
  };
  bool member_at(const Endpoint& where, const View& view) const;
  Side ours(const View& view) const;
  wire::Probe our_probe(bool knows, const View& view) const;
  /// Sends a Probe in reply; without a key, only if it is no larger than what that address has sent so far.
  void reply_within_credit(const Endpoint& to, std::size_t bytes, const View& view, Commands& out);

  const SessionView& session_;
  std::vector<Gone> gone_;
  std::vector<Credit> credits_;                  ///< kMost at most
  std::map<PeerId, std::uint32_t> disowned_by_;  ///< members whose Probes disown us, and their incarnations
  std::optional<Endpoint> winner_;
  Tick probed_ = 0;
  Tick won_at_ = 0;
};

}  // namespace padr::node
