#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/sync/fold.h"

namespace padr::sync {

/// Hashes one state after another. Who owns and holds what, and which bodies are in a region, is mostly as it was in
/// the state before, and then it is compared and not hashed: that takes half the time.
class StateHasher {
 public:
  /// A function of `s` alone, contact memory included.
  std::uint64_t operator()(const FoldState& s);

 private:
  std::vector<Authority> authority_;  ///< as `bodies_` is the hash of
  std::vector<PeerSet> holds_;
  std::optional<std::uint64_t> bodies_;
  Residents residents_;  ///< as `within_` is the hash of
  std::optional<std::uint64_t> within_;
};

/// As a new StateHasher has it, and so any other.
std::uint64_t hash_of(const FoldState& s);

/// The hash of a state for whoever may not want it: worked out when it is first read, as the number that it is.
class LazyHash {
 public:
  /// `s` must be there, and the same, for as long as this is; `hasher` must be there.
  LazyHash(const FoldState& s, StateHasher& hasher) : state_(&s), hasher_(&hasher) {}
  operator std::uint64_t() const {  // NOLINT(google-explicit-constructor): stands for it
    if (!known_) known_ = (*hasher_)(*state_);
    return *known_;
  }

 private:
  const FoldState* state_;
  StateHasher* hasher_;
  mutable std::optional<std::uint64_t> known_;
};

}  // namespace padr::sync
