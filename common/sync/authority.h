#pragma once

#include <cstdint>

#include "common/model/ids.h"

namespace padr::sync {

/// Who may say what a body's state is.
struct Authority {
  PeerId owner = kNoPeer;  ///< who claimed this epoch; kNoPeer before the first claim
  bool released = true;    ///< the owner has given it up since: nobody owns the body, the epoch still counts
  std::uint32_t epoch = 0;
  Tick claimed = 0;  ///< tick of the claim
  friend bool operator==(const Authority&, const Authority&) = default;

  /// The present owner, or kNoPeer.
  PeerId holder() const { return released ? kNoPeer : owner; }
};

/// Whether `claim` beats `present` for `body`. In plain words: the higher epoch wins; of two claims of the same epoch
/// the one made at the earlier tick; of two made at the same tick the one with the smaller hash of (peer, body,
/// epoch), which favours nobody. The same owner's further updates in its epoch are not contests: they pass.
/// A total order, so all peers agree whatever order claims arrive in.
bool wins(const Authority& claim, const Authority& present, EntityId body);

/// Whether a claim that was told at tick `told` may rest on what is on record. A claim adds one to an epoch, once a
/// tick; claims that were declared void, or told a little later as an update was full, leave gaps. A claim that could
/// not have come about like that counts for nobody, so no lie about epochs or ticks takes a body for long.
bool may_rest_on(const Authority& claim, const Authority& present, Tick told);

}  // namespace padr::sync
