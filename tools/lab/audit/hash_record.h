#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/model/ids.h"

namespace padr::lab::audit {

/// What the members said of their confirmed worlds, against those of one trace.
class HashRecord {
 public:
  using Sitter = std::pair<PeerId, std::uint32_t>;  ///< slot, incarnation

  /// The trace has confirmed a tick.
  void confirmed(Tick tick, std::uint64_t hash);
  /// At its tick `at` a member said what it had confirmed of `tick`.
  void told(Sitter who, Tick at, Tick tick, std::uint32_t hash);

  /// The last tick that the member said it had confirmed by its tick `at`; -1: it had not said any.
  Tick confirmed_by(Sitter who, Tick at) const;
  enum class Verdict : std::uint8_t { kUnknown, kSame, kDiffers };
  /// Whether the member's world of the last tick up to `tick` that it told of was the trace's.
  Verdict before(Sitter who, Tick tick) const;
  /// Of the first tick after it.
  Verdict after(Sitter who, Tick tick) const;

 private:
  struct Told {
    Tick at = 0;
    Tick tick = 0;
    std::uint32_t hash = 0;
  };
  Verdict compare(const Told& told) const;

  std::map<Tick, std::uint32_t> own_;
  std::map<Sitter, std::vector<Told>> told_;  ///< by tick
};

}  // namespace padr::lab::audit
