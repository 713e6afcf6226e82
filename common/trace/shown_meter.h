#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "common/model/scene.h"
#include "common/model/state.h"
#include "common/world/overlap.h"

namespace padr::trace {

/// How what is shown moves, beside how what is simulated does: of one view, or of several together. docs/metrics.md has
/// the definitions.
struct ShownMotion {
  std::uint64_t ticks = 0;
  double stride_change_m = 0;  ///< sum over entities and ticks: how much a shown step differs from the step before
  double unexplained_m = 0;    ///< its part that the entity's velocity does not explain
  std::uint64_t stops = 0;
  double overshoot_m = 0;       ///< sum over stops
  double overshoot_peak_m = 0;  ///< of one
  double overlap_m = 0;         ///< sum over pairs and ticks: depth beyond the live world's
  double overlap_made_m = 0;    ///< its part that was not in the live world before, either
  double overlap_peak_m = 0;    ///< of one pair at one tick
  std::uint64_t freezes = 0;
  Tick longest_freeze = 0;  ///< ticks

  double overshoot_mean_m() const { return stops > 0 ? overshoot_m / static_cast<double>(stops) : 0; }
  // Means over time, 0 without any.
  double stride_change_m_per_s() const { return per_tick(stride_change_m) * kTicksPerSecond; }
  double unexplained_m_per_s() const { return per_tick(unexplained_m) * kTicksPerSecond; }
  double overlap_mean_m() const { return per_tick(overlap_m); }
  double overlap_made_mean_m() const { return per_tick(overlap_made_m); }
  double freezes_per_s() const { return per_tick(static_cast<double>(freezes)) * kTicksPerSecond; }
  double longest_freeze_s() const { return static_cast<double>(longest_freeze) / kTicksPerSecond; }
  void add(const ShownMotion& other);

 private:
  double per_tick(double sum) const { return ticks > 0 ? sum / static_cast<double>(ticks) : 0; }
};

/// Looks at one view. Needs no more than a trace holds.
class ShownMeter {
 public:
  ShownMeter(const Scene& scene, int slots);

  /// A tick: the live world, the shown positions (m), and what is there, by entity id. Ticks come in order.
  void tick(std::span<const BodyState> live, std::span<const Vec2> shown, const std::vector<bool>& present);

  const ShownMotion& result() const { return sum_; }

 private:
  /// An entity that has been moving and may be about to stop.
  struct Stop {
    Vec2 way;            ///< unit, in which it moved; zero: it did not
    float reach = 0;     ///< m along it: as far as the live entity got, or was shown when it was fast last
    float farthest = 0;  ///< m along it, that it was shown
    Tick slow = 0;       ///< ticks since it was fast
    bool stands = false;
  };
  struct Seen {
    bool there = false;
    bool rests = false;  ///< nothing goes on: the same again changes nothing
    Vec2 shown;          ///< m
    Vec2 stride;         ///< m, of the last tick
    Vec2 expected;       ///< m: to go on so is no change; after a jump not the jump, but what the velocity explains
    Tick frozen = 0;
    Stop stop;
  };
  struct Thing {
    world::Outline shape;
    world::Pose live;
    world::Pose shown;
    world::Pose before;  ///< as shown a tick ago
  };
  void follow(Seen& seen, const BodyState& live, Vec2 shown);
  void take_freeze(Seen& seen, const BodyState& live, Vec2 shown, Vec2 stride);
  void take_stop(Stop& stop, const BodyState& live, Vec2 shown);
  void end(Stop& stop);
  void take_overlaps(std::span<const BodyState> live, std::span<const Vec2> shown, const std::vector<bool>& present);
  void take_overlap(std::pair<std::size_t, std::size_t> who, const Thing& a, const Thing& b);

  std::vector<world::Outline> outlines_;  ///< by entity
  std::vector<float> reaches_;            ///< by entity, m
  std::vector<Thing> fixed_;
  std::vector<Seen> seen_;  ///< by entity
  /// By pair whose shown overlap is deeper than the live one: how much of it the live world had, m.
  using Depths = std::map<std::pair<std::size_t, std::size_t>, float>;
  Depths had_;
  Depths had_now_;
  ShownMotion sum_;
};

}  // namespace padr::trace
