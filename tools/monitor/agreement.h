#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "common/model/ids.h"

namespace padr::monitor {

/// Whether confirmed worlds are the same: hashes that peers tell, compared at equal ticks.
class Agreement {
 public:
  enum class Verdict : std::uint8_t { kUnknown, kIdentical, kApart, kDiffers };

  /// The confirmed world of `tick` has this hash, says who sits in `slot`.
  void note(PeerId slot, Tick tick, std::uint64_t hash);
  /// Whether a slot's world that is another one may be so: `apart` says that the peer and those whose world is held to
  /// be right have evicted each other. Until then it is not known.
  void settle(PeerId slot, bool apart);
  /// What the slot said counts no more: somebody else sits there, or nobody.
  void forget(PeerId slot);

  /// Of one slot, by the newest tick that somebody else told of, too. Of two worlds, that of more peers is held to be
  /// right; of two of equally many, that of the lowest slot.
  Verdict of(PeerId slot) const;
  /// Whether there is a difference of its world's for settle() to judge.
  bool is_open(PeerId slot) const;
  /// Of all: the last in the order of Verdict, but unknown if there is nothing else. Once all are forgotten, as before
  /// that.
  Verdict all() const;
  /// Ticks at which at least two were compared, each time that a further peer was.
  std::uint64_t compared() const { return compared_; }
  /// The newest tick that at least two told of; -1: none.
  Tick newest() const { return newest_; }
  /// The first tick at which somebody's world differed from that of others in its part.
  std::optional<Tick> first_difference() const { return first_difference_; }

 private:
  static constexpr std::size_t kTicks = 512;  // kept: peers confirm at different times, but within seconds
  void judge(Tick tick, const std::map<PeerId, std::uint64_t>& told);

  std::map<Tick, std::map<PeerId, std::uint64_t>> told_;
  struct State {
    Tick tick = -1;
    bool other = false;  ///< at that tick its world is not the one that is held to be right
    Tick open = -1;      ///< first tick at which it was not, and nobody has told yet why; -1: none
    Verdict verdict = Verdict::kUnknown;
  };
  std::map<PeerId, State> states_;
  Verdict last_ = Verdict::kUnknown;  ///< of all, when the last was forgotten
  std::uint64_t compared_ = 0;
  Tick newest_ = -1;
  std::optional<Tick> first_difference_;
};

}  // namespace padr::monitor
