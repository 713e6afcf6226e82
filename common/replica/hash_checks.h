#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/model/ids.h"

namespace padr::node {

/// Hashes of confirmed worlds: this peer's recent ones, and other peers' for ticks that are not confirmed here yet.
class HashChecks {
 public:
  /// The hash of another peer's confirmed world at a tick, as that peer sent it.
  struct Told {
    Tick tick = 0;
    PeerId from = kNoPeer;
    std::uint32_t incarnation = 0;
    std::uint32_t hash = 0;
  };

  HashChecks() {
    own_.reserve(kKept);
    waiting_.reserve(kKept);
  }

  /// Adds this peer's own hash, of a later tick than any before.
  void add_own(Tick tick, std::uint32_t hash);
  /// This peer's own hash of the latest tick; tick -1 if there is none.
  struct Own {
    Tick tick = -1;
    std::uint32_t hash = 0;
  };
  Own newest() const { return own_.empty() ? Own{} : own_.back(); }
  /// The own hash of that tick, if it is kept; null otherwise.
  const Own* own(Tick tick) const;

  /// Keeps a hash until its tick is confirmed here: the first of each peer and tick, and at most kKept of one peer.
  void put_off(const Told& told);
  /// Takes out a hash of a tick up to `confirmed`, lowest tick first; false if there is none.
  bool take(Tick confirmed, Told& out);
  std::size_t waiting() const { return waiting_.size(); }

  static constexpr std::size_t kKept = 64;

 private:
  std::vector<Own> own_;       ///< ascending, kKept at most
  std::vector<Told> waiting_;  ///< by descending tick
};

}  // namespace padr::node
