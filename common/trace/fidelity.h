#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/model/scene.h"
#include "common/model/state.h"
#include "common/trace/doers.h"
#include "common/trace/physics_consistency_cost.h"
#include "common/trace/player_view.h"
#include "common/trace/undisturbed.h"

namespace padr::trace {

/// How far bodies of one view are, at one tick, from where the players' deeds alone put them, summed over bodies.
struct FidelityPoint {
  Tick tick = 0;
  float own_m = 0;     ///< of bodies that the view's own player had to do with
  float others_m = 0;  ///< of bodies that another player had to do with
  float nobody_m = 0;  ///< of bodies that nobody had to do with
  float error_m() const { return own_m + others_m + nobody_m; }
};

using FidelitySeries = std::vector<FidelityPoint>;

/// Fidelity error of one view over the ticks measured, in metres; 0 is perfect.
struct Fidelity {
  std::uint64_t ticks = 0;
  double mean_m = 0;
  double own_mean_m = 0;  ///< these three are the parts of it, as in FidelityPoint
  double others_mean_m = 0;
  double nobody_mean_m = 0;
  double p95_m = 0;
  double peak_m = 0;
};

Fidelity summarize(const FidelitySeries& series);
/// The mean over several peers' series, ticks weighted alike; the peak is the highest of any.
Fidelity summarize_all(const std::vector<FidelitySeries>& series);

/// Whether what views show is what the players did, as docs/metrics.md defines it: every body is compared with where it
/// is in the undisturbed copy of the live world of the player who had to do with it; for a body that nobody had to do
/// with, in the copy of the viewer's own. Bodies that several players had to do with within a second are left out.
/// Needs no more than a trace holds. Entities 0 .. bodies-1 are bodies, bodies + p the avatar of slot p.
class FidelityMeter {
 public:
  /// Viewers are 0, 1, ... and sit where `viewers` says; several may sit in a slot, one after the other. `slots`:
  /// avatar slots of the session; those of which there is no viewer may have avatars all the same.
  FidelityMeter(const Scene& scene, int slots, std::vector<PeerId> viewers);

  /// A tick, with what every viewer has. Ticks come in order; after a gap copies are taken anew.
  void tick(Tick now, std::span<const PlayerView> views);
  /// Somebody beyond the players has pushed the body.
  void pushed(EntityId body, Tick now) { doers_.touched(body, unseen_, now); }

  const FidelitySeries& series(std::size_t viewer) const { return series_[viewer]; }
  Fidelity result(std::size_t viewer) const { return summarize(series_[viewer]); }
  Fidelity overall() const { return summarize_all(series_); }
  /// How often the viewer's avatar began to touch bodies, counted anew after each horizon.
  std::uint64_t deeds(std::size_t viewer) const { return copies_[viewer]->deeds(); }
  /// Of the time that bodies were somebody's, how much was left out, 0 .. 1.
  double left_out() const;
  const PccMeter& pcc() const { return pcc_; }

 private:
  void see_avatars(std::span<const PlayerView> views);
  void step_copy(std::size_t viewer, const PlayerView& view, bool gap);
  void look_for_doers(Tick now, std::span<const PlayerView> views);
  FidelityPoint measure(Tick now, std::size_t viewer, const PlayerView& view) const;

  std::size_t bodies_;
  std::vector<PeerId> viewers_;
  std::size_t unseen_;  ///< doer that stands for whoever is no viewer
  std::vector<std::unique_ptr<Undisturbed>> copies_;
  Doers doers_;
  PccMeter pcc_;
  std::vector<std::vector<BodyState>> before_;  ///< by viewer
  std::vector<char> is_others_;                 ///< by body
  std::vector<char> watched_;                   ///< by slot: some viewer sits in it
  std::vector<char> present_;                   ///< by slot
  Tick last_ = -1;
  std::vector<FidelitySeries> series_;
  std::uint64_t somebodys_ = 0;  ///< bodies times ticks
  std::uint64_t severals_ = 0;
};

}  // namespace padr::trace
