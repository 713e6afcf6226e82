#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/model/ids.h"

namespace padr::node {

/// Hashes of confirmed worlds: the own ones of late, and what others have told of ticks that are not confirmed here
/// yet.
class HashChecks {
 public:
  /// What somebody says its confirmed world's hash was at a tick.
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

  /// This peer's own, of a later tick than any before.
  void add_own(Tick tick, std::uint32_t hash);
  /// Of the latest tick that has one; tick -1 if none has.
  struct Own {
    Tick tick = -1;
    std::uint32_t hash = 0;
  };
  Own newest() const { return own_.empty() ? Own{} : own_.back(); }
  /// The own one of that tick, if it is kept; null otherwise.
  const Own* own(Tick tick) const;

  /// Kept until its tick is confirmed here; the first word of a peer on a tick counts, and kKept of one peer at most.
  void put_off(const Told& told);
  /// Takes out one of a tick up to `confirmed`, lowest tick first; false if there is none.
  bool take(Tick confirmed, Told& out);
  std::size_t waiting() const { return waiting_.size(); }

  static constexpr std::size_t kKept = 64;

 private:
  std::vector<Own> own_;       ///< ascending, kKept at most
  std::vector<Told> waiting_;  ///< by descending tick
};

}  // namespace padr::node
