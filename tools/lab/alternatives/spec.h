#pragma once

#include <cstdint>
#include <memory>

#include "common/model/ids.h"
#include "common/model/scene.h"

namespace padr::lab::alternatives {

enum class Kind : std::uint8_t {
  kSnapshot,
  kStateSync,
  kDis,
  kInputs,   ///< inputs alone are sent: rollback, and lockstep, which predicts nothing
  kEntrant,  ///< of a file in entrants/, made by Spec::make
};

/// How far a peer simulates beyond the others' inputs: MAX_PREDICTION_FRAMES of GGPO's sync.h.
inline constexpr Tick kGgpoPrediction = 8;
/// More than a second of either makes no sense.
inline constexpr Tick kMostInputDelay = 60;
inline constexpr Tick kMostPrediction = 60;
/// Steps per metre of places in whole numbers.
inline constexpr int kFinestPlace = 2048;

class Alternative;
struct AlternativeConfig;
/// Makes one peer of an entrant.
using Maker = std::unique_ptr<Alternative> (*)(const Scene& scene, const AlternativeConfig& config);

/// Which alternative, and its parameters.
struct Spec {
  Kind kind = Kind::kSnapshot;
  int hz = 20;                        ///< datagrams a second to each peer: state-sync 1 .. 60, others a divisor of 60
  float position_threshold = 1;       ///< m, dis
  float angle_threshold = 0.0524F;    ///< rad, dis; 3 degrees
  Tick input_delay = 0;               ///< inputs: 0 .. kMostInputDelay
  Tick prediction = kGgpoPrediction;  ///< inputs: 0, which is lockstep, .. kMostPrediction
  int steps_per_m = kFinestPlace;     ///< of places, all but dis: 16 .. kFinestPlace
  Maker make = nullptr;               ///< entrants
};

}  // namespace padr::lab::alternatives
