#pragma once

#include <cstdint>
#include <vector>

#include "common/model/endpoint.h"
#include "common/sync/fold.h"

namespace padr::sync {

/// All that a peer needs to go on where another one is: a confirmed state, and every update known beyond it.
///
/// It is enough for confirmed worlds to be the same to the bit from there on, because a step depends on nothing but the
/// state: world::World orders its contacts before every step and its snapshots carry their memory.
struct Transfer {
  static constexpr std::size_t kMostGone = 64;
  struct Slot {
    std::uint32_t first = 0;  ///< number of the slot's first update that is not in `state`
    Endpoint at;              ///< of who sits there; not set for the sender
    Tick since = 0;           ///< tick at which that peer was first admitted to the session
  };
  /// A peer that was evicted.
  struct Gone {
    Endpoint at;
    Tick since = 0;    ///< tick at which it was first admitted, at most `removed`
    Tick removed = 0;  ///< tick of its removal
    friend bool operator==(const Gone&, const Gone&) = default;
  };
  /// Two signed updates of one peer that no honest peer can both have published: see wire::contradict.
  struct Proof {
    PublicKey key{};
    std::uint32_t incarnation = 0;
    Bundle one;
    Bundle other;
    friend bool operator==(const Proof&, const Proof&) = default;
  };
  static constexpr std::size_t kMostProofs = 8;
  PeerId by = kNoPeer;  ///< the slot of its sender; the receiver knows it
  FoldState state;
  std::vector<Slot> slots;
  std::vector<Bundle> tail;         ///< by tick and peer
  std::vector<std::uint32_t> have;  ///< by slot: with `tail`, all its updates below this are known
  std::vector<Gone> gone;           ///< those who were evicted; at most kMostGone
  std::vector<Proof> proofs;        ///< that members have published two different updates; at most kMostProofs
};

/// Where a region of a crowd begins at tick `now`: as its scene says, with nobody there but whoever founds it, who sits
/// in slot 0, as `incarnation`. Its replica goes on from there like any newcomer's, and is in at once.
Transfer founding(const Scene& scene, int slots, bool authority, Tick now, std::uint32_t incarnation);
/// Where a session goes on from `last`, the latest state that is known, with nobody there but one peer, who sits in
/// slot 0 anew, as `incarnation`, above all others by at least two. `have`: updates of each slot so far.
Transfer founding_anew(const Scene& scene, bool authority, const FoldState& last, std::vector<std::uint32_t> have,
                       std::uint32_t incarnation, bool spectates);
/// The founder's incarnation is drawn from 1 to this, so that two who found one region are hardly ever taken for one;
/// small enough for two bytes in every datagram.
inline constexpr std::uint32_t kMostFounding = 8191;

}  // namespace padr::sync
