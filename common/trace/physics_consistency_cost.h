#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/model/scene.h"
#include "common/trace/doers.h"
#include "common/trace/player_view.h"

namespace padr::trace {

/// Physics-consistency-cost of one avatar at one tick.
struct PccPoint {
  Tick tick = 0;
  float cost_m = 0;          ///< sum over bodies that it disturbed last, mean over the others' views
  std::uint16_t bodies = 0;  ///< of those, how many are off by more than kOff in somebody's view
};

using PccSeries = std::vector<PccPoint>;

/// The physics-consistency-cost of an avatar over the ticks measured.
struct Pcc {
  std::uint64_t ticks = 0;
  double mean_m = 0;
  double peak_m = 0;
  double bodies_mean = 0;
  int bodies_peak = 0;
};

Pcc summarize(const PccSeries& series);

/// The inconsistency that an avatar's model error causes in bodies (paper, section II.c), as docs/metrics.md defines
/// it: how far bodies that it disturbed last are in others' views from where its own player has them.
///
/// Disturbed by it: the body is its, as Doers says, when views part over it. Where nobody had to do with it, the avatar
/// that is seen at the body in some other player's view, or at one that is off by it: the model did it.
class PccMeter {
 public:
  /// Bodies that are off by more count, m: of those, "complexity" in the paper's words.
  static constexpr float kOff = 0.05F;

  PccMeter(const Scene& scene, int slots, std::vector<PeerId> viewers);

  void tick(Tick now, std::span<const PlayerView> views, const Doers& doers);

  /// Of the avatar of that viewer.
  const PccSeries& series(std::size_t viewer) const { return series_[viewer]; }
  Pcc result(std::size_t viewer) const { return summarize(series_[viewer]); }

 private:
  bool is_off(EntityId body, std::span<const PlayerView> views) const;
  int seen_at(EntityId body, std::span<const PlayerView> views) const;
  void attribute(std::span<const PlayerView> views, const Doers& doers);
  void add(EntityId body, std::span<const PlayerView> views);

  std::size_t bodies_;
  std::vector<PeerId> viewers_;
  std::vector<float> reach_;    ///< by entity, m
  std::vector<int> disturber_;  ///< by body: a viewer or kNobody
  std::vector<char> off_;       ///< by body: views part over it
  std::vector<EntityId> list_;  ///< the bodies that are off
  std::vector<PccPoint> sums_;  ///< by viewer, of the tick
  std::vector<PccSeries> series_;
};

}  // namespace padr::trace
