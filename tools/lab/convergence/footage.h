#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "tools/lab/simulation.h"

namespace padr::lab::convergence {

inline constexpr std::array<Convergence, 4> kMethods{Convergence::kSnap, Convergence::kBlend, Convergence::kPvb,
                                                     Convergence::kTrack};
inline constexpr std::array<std::string_view, kMethods.size()> kNames{"snap", "blend", "pvb", "track"};

/// What one peer is shown of the others' entities in one session, by each method. What is simulated is the same to the
/// bit: only the showing differs.
struct Footage {
  using Positions = std::vector<Vec2>;  ///< m, by entity id
  PeerId viewer = 0;
  std::array<std::vector<Positions>, kMethods.size()> shown;  ///< by method, then tick from 1 on
  std::vector<Positions> truth;                               ///< by tick: where its authority has it
  std::vector<std::vector<float>> angles;                     ///< rad, by tick, in the viewer's live world
  std::vector<std::vector<bool>> foreign;                     ///< by tick, entity: another peer's, not the viewer's
};

/// Three sessions of `config`, alike but for the method, played side by side and filmed; the simulations are left for
/// their meters.
struct Takes {
  explicit Takes(const SimulationConfig& config, PeerId viewer);
  /// Plays all ticks.
  void run();

  std::array<std::unique_ptr<Simulation>, kMethods.size()> simulations;
  Footage footage;

 private:
  void film();
  Tick ticks_;
};

/// A correction worth a look.
struct Moment {
  Tick tick = -1;  ///< of the correction; -1: there is none
  EntityId entity = 0;
  float metres = 0;  ///< it was put so far
};

/// The largest correction of at most `most` metres of an avatar, or of a body, with `before` ticks before it and
/// `after` behind during which the entity was another peer's. `bodies`: entities below are bodies.
Moment largest_correction(const Footage& f, int bodies, bool of_body, float most, Tick before, Tick after);

}  // namespace padr::lab::convergence
