#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "common/link/link_mesh.h"
#include "common/scenarios/input.h"
#include "common/trace/fidelity.h"
#include "common/trace/metrics.h"
#include "tools/lab/alternatives/alternative.h"
#include "tools/lab/alternatives/timeline.h"
#include "tools/lab/measure/jumps.h"
#include "tools/lab/measure/processor_time.h"

namespace padr::lab::alternatives {

struct SessionConfig {
  Scene scene;
  int peers = 2;
  Spec spec;
  link::NetemSpec netem;  ///< of every directed link
  std::uint64_t netem_seed = 1;
  std::vector<scenarios::InputSource*> inputs;  ///< by peer; not owned
  bool processor_time = false;                  ///< is measured
};

/// What hands and eyes meet, all peers together.
struct Waiting {
  double hand_delay_s = 0;       ///< from an input at the hand to its own avatar that follows it, mean over ticks
  double hand_delay_peak_s = 0;  ///< the longest
  double frozen_share = 0;       ///< of ticks at which a view stood still, 0 .. 1
  double freezes = 0;            ///< how often a view came to stand still, per peer and second
};

/// N peers of an alternative in lock step, on the clock, the links and with the meter that lab::Simulation has.
///
/// The truth, as for our techniques: the authority of record of a body at a tick is the best of all claims that have
/// been made by then, whoever has heard of them, which only the lab can know; the truth is where that peer has it. An
/// alternative that simulates from inputs alone has no authority: its truth is its timeline, with nothing late and
/// nothing guessed.
class AlternativeRun {
 public:
  explicit AlternativeRun(SessionConfig config);

  void step();
  Tick now() const { return now_; }
  const Alternative& peer(PeerId p) const { return *peers_[p]; }
  /// Against now.
  const trace::InconsistencyMeter& meter() const { return meter_; }
  const trace::FidelityMeter& fidelity() const { return fidelity_; }
  /// Mean combined inconsistency (m) of what is shown against the truth of the time that it is meant to show; and that
  /// time's age (s).
  double delayed_mean_m() const;
  double delay_s() const;
  /// Who owns a body by that rule; kNoPeer where there is no authority.
  PeerId owner(EntityId body) const;
  Waiting waiting() const;
  /// Mean combined inconsistency (m) against where the hands of now put things, input delay or not.
  double hands_mean_m() const;
  const JumpMeter& jumps(PeerId p) const { return jumps_[p]; }
  /// Of ticks of which a peer had all inputs: those at which its world was not the timeline's, to the bit.
  std::uint64_t mismatches() const { return mismatches_; }
  /// Null unless it was asked for.
  const ProcessorTime* processor_time() const { return processor_time_.get(); }

 private:
  struct Past {
    std::vector<PeerId> owner;              ///< by entity
    std::vector<std::vector<Vec2>> places;  ///< by peer, by entity
    std::vector<Vec2> hands;                ///< m, by peer
  };
  void sample();
  void measure_fidelity();
  void measure_delayed();
  void measure_waiting();
  void measure_timeline(PeerId p, const std::vector<Vec2>& places);
  Vec2 driven_towards(PeerId p) const;
  void work();

  SessionConfig config_;
  Tick now_ = 0;
  std::vector<std::unique_ptr<Alternative>> peers_;
  link::LinkMesh links_;
  trace::InconsistencyMeter meter_;
  trace::FidelityMeter fidelity_;
  std::vector<Vec2> targets_;                   ///< by peer, of the last step
  std::vector<std::vector<BodyState>> states_;  ///< by peer
  std::deque<Past> past_;                       ///< the newest last
  double delayed_sum_ = 0;
  double delay_sum_ = 0;
  std::uint64_t delayed_views_ = 0;
  std::uint64_t delays_ = 0;
  std::unique_ptr<Timeline> timeline_;  ///< of inputs; null where there is authority
  std::unique_ptr<ProcessorTime> processor_time_;
  std::vector<JumpMeter> jumps_;  ///< by peer
  std::vector<char> stood_;       ///< by peer: whether its view stood still at the last tick
  double hands_sum_ = 0;
  double hand_delay_sum_ = 0;  ///< ticks
  Tick hand_delay_peak_ = 0;
  std::uint64_t frozen_ = 0;
  std::uint64_t freezes_ = 0;
  std::uint64_t mismatches_ = 0;
};

}  // namespace padr::lab::alternatives
