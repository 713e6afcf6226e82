#pragma once

#include <array>

#include "tools/lab/figures/run.h"

namespace padr::lab::figures {

/// One run in numbers. All of what the watching peer sees.
struct Measures {
  trace::Inconsistency combined;
  trace::Fidelity fidelity;
  trace::Pcc pcc;  ///< of the driven avatar
  double avatar_peak_m = 0;
  double body_peak_m = 0;
  std::array<double, 3> thirds_m{};  ///< means of the first, second and last third of the run
  double trend_m_per_min = 0;        ///< slope of the straight line that fits best
  double bodies_off_m = 0;           ///< at the end: what bodies are still off by
  double above_longest_s = 0;        ///< longest time without a moment below the threshold (the high one)
  /// Of the ticks at which the avatar touches nothing, those within the threshold (the high one) and what the avatar
  /// can move in the tick that an update takes to arrive; 0 .. 1.
  double free_within_share = 0;
  double within_share = 0;     ///< the same of all ticks
  bool peak_touching = false;  ///< whether the avatar touched a body when the peak was reached
  double updates_per_min = 0;
  double kbps = 0;       ///< on the wire, IP and UDP headers included
  double low_share = 0;  ///< of the time, that a threshold below the high one was in force, 0 .. 1
};

/// `threshold_high` in m; `tick_way`: what an avatar can move in a tick, m.
Measures measure(const FigureRun& run, double threshold_high, double tick_way);

}  // namespace padr::lab::figures
