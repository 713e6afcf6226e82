#pragma once

#include <array>
#include <cstdint>

#include "tools/lab/simulation.h"

namespace padr::lab {

/// Means per peer and second over the whole run.
struct Rates {
  double updates = 0;
  double datagrams = 0;
  double kbps = 0;
  double repeats = 0;
  double replay_steps_per_tick = 0;
  double lookahead_steps_per_tick = 0;
  /// Of all physics steps: look-ahead against live, predicted, replayed ones and itself, 0 .. 1.
  double lookahead_share() const {
    return lookahead_steps_per_tick / (2 + replay_steps_per_tick + lookahead_steps_per_tick);
  }
  double snaps = 0;        ///< jumps of shown positions by more than 3 cm
  double snap_m = 0;       ///< their sum, m
  double snap_peak_m = 0;  ///< the largest of all, m
  trace::ShownMotion shown;
  std::array<double, sync::kCauses> by_cause{};
  std::uint64_t hash_mismatches = 0;
};

/// Of `n` peers from `from` on together.
Rates rates_of(const Simulation& s, PeerId from, int n);

}  // namespace padr::lab
