#pragma once

#include <deque>
#include <span>
#include <vector>

#include "tools/lab/alternatives/input_track.h"

namespace padr::lab::alternatives {

/// What an alternative that simulates from inputs alone comes to when nothing is late and nothing guessed, which only
/// the lab can know at once: the truth that peers are held against.
class Timeline {
 public:
  Timeline(const Scene& scene, int peers, const Spec& spec);

  /// The next tick, with where the hands are at it (m, by peer).
  void step(std::span<const Vec2> hands);
  /// Where things are at this tick, m, by entity: by the inputs of the input delay ago.
  const std::vector<Vec2>& present() const { return moment(now_).places; }
  /// Where the hands of this tick have put them, which nobody sees before the input delay is over.
  const std::vector<Vec2>& decided() const { return moment(now_ + delay_).places; }
  /// Whether that is the state of that tick to the bit; true for ticks that are not kept any more.
  bool agrees(Tick tick, const world::Snapshot& state) const;

 private:
  struct Moment {
    std::vector<Vec2> places;
    std::uint64_t hash = 0;
  };
  const Moment& moment(Tick tick) const { return moments_[static_cast<std::size_t>(tick - first_)]; }
  void keep();

  Quantiser quantiser_;
  world::World world_;
  Tick delay_;
  Tick now_ = 0;
  std::deque<Moment> moments_;
  Tick first_ = 0;  ///< of those that are kept
  std::vector<Quantised> inputs_;
  world::Snapshot snapshot_;
};

}  // namespace padr::lab::alternatives
