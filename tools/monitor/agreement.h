#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "common/model/ids.h"

namespace padr::monitor {

/// Whether confirmed worlds are the same: hashes that peers tell, compared at equal ticks.
class Agreement {
 public:
  enum class Verdict : std::uint8_t { kUnknown, kIdentical, kDiffers };

  /// The confirmed world of `tick` has this hash, says who sits in `slot`.
  void note(PeerId slot, Tick tick, std::uint64_t hash);
  /// What the slot said counts no more: somebody else sits there, or nobody.
  void forget(PeerId slot);

  /// Of one slot, by the newest tick that somebody else told of, too. Of two worlds, that of more peers is held to be
  /// right; of two of equally many, that of the lowest slot.
  Verdict of(PeerId slot) const;
  /// Of all: differs if anybody's does.
  Verdict all() const;
  /// Ticks at which at least two were compared, each time that a further peer was.
  std::uint64_t compared() const { return compared_; }
  /// The newest tick that at least two told of; -1: none.
  Tick newest() const { return newest_; }
  std::optional<Tick> first_difference() const { return first_difference_; }

 private:
  static constexpr std::size_t kTicks = 512;  // kept: peers confirm at different times, but within seconds
  void judge(Tick tick, const std::map<PeerId, std::uint64_t>& told);

  std::map<Tick, std::map<PeerId, std::uint64_t>> told_;
  struct State {
    Tick tick = -1;
    bool differs = false;
  };
  std::map<PeerId, State> states_;
  std::uint64_t compared_ = 0;
  Tick newest_ = -1;
  std::optional<Tick> first_difference_;
};

}  // namespace padr::monitor
