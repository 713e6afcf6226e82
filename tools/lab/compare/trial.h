#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/trace/fidelity.h"
#include "common/trace/metrics.h"
#include "tools/lab/compare/contestant.h"

namespace padr::lab::compare {

/// What all contestants meet alike.
struct Setting {
  std::string scenario = "arena";
  int peers = 4;
  Tick ticks = 0;
  std::vector<std::string> inputs{"wander"};  ///< dealt round to the peers
  bool processor_time = false;                ///< is measured
};

/// A network that every directed link is.
struct Network {
  std::string text;  ///< as the flag was written
  link::NetemSpec spec;
};

/// What one run came to.
struct Score {
  trace::Inconsistency off;  ///< all views together, against now
  trace::Fidelity fidelity;  ///< all views together
  double kbps = 0;           ///< sent per peer, IP and UDP headers included
  double datagrams = 0;      ///< per peer and second
  double updates = 0;        ///< entity states told, per peer and second
  /// Of techniques that show the past on purpose: how old what they show is (s), and its mean combined inconsistency
  /// against the truth of that time (m). Otherwise 0 and off.mean_m.
  double delay_s = 0;
  double delayed_mean_m = 0;
  /// Against where the hands of now put things, input delay or not (m); off.mean_m where there is none.
  double hands_mean_m = 0;
  double hand_delay_s = 0;       ///< from an input at the hand to its own avatar that follows it, mean over ticks
  double hand_delay_peak_s = 0;  ///< the longest
  double frozen_share = 0;       ///< of ticks at which a view stood still, 0 .. 1
  double freezes = 0;            ///< how often one came to stand still, per peer and second
  double jumps = 0;              ///< of shown positions by more than 3 cm, per peer and second
  double jump_m = 0;             ///< of those, the mean
  std::optional<double> processor_steps;  ///< of a peer in a tick, in steps of a bare world; if it was measured
  std::uint64_t largest = 0;              ///< bytes of the largest datagram, without IP and UDP; 0: not measured
  /// Of all ticks, those at which `off` was measured: those that were confirmed in time, where things are confirmed.
  double measured_share = 1;
  std::uint64_t mismatches = 0;  ///< confirmed ticks at which worlds differed; 0 where nothing is confirmed
};

inline bool has_any(const Score&) {
  return true;
}
/// Whether jump_m is one: a jump is over 3 cm, and the 0 of a run without any would be none.
inline bool has_jumps(const Score& s) {
  return s.jumps > 0;
}

/// Throws UserError for what run_trial() would refuse: a scenario or an input that does not work, or too many peers.
void check_setting(const Setting& setting, std::uint64_t seed);

/// One run; the same arguments give the same score to the bit, but for processor time. `seed` is that of scenario,
/// generated input and network. Throws UserError for a scenario or an input that does not work.
Score run_trial(const Contestant& contestant, const Network& network, const Setting& setting, std::uint64_t seed);

}  // namespace padr::lab::compare
