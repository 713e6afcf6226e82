#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "common/link/link_mesh.h"
#include "common/scenarios/input.h"
#include "common/trace/fidelity.h"
#include "common/trace/metrics.h"
#include "tools/lab/alternatives/alternative.h"

namespace padr::lab::alternatives {

struct SessionConfig {
  Scene scene;
  int peers = 2;
  Spec spec;
  link::NetemSpec netem;  ///< of every directed link
  std::uint64_t netem_seed = 1;
  std::vector<scenarios::InputSource*> inputs;  ///< by peer; not owned
};

/// N peers of an alternative in lock step, on the clock, the links and with the meter that lab::Simulation has.
///
/// The truth, as for our techniques: the authority of record of a body at a tick is the best of all claims that have
/// been made by then, whoever has heard of them, which only the lab can know; the truth is where that peer has it.
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
  /// Who owns a body by that rule.
  PeerId owner(EntityId body) const;

 private:
  struct Past {
    std::vector<PeerId> owner;              ///< by entity
    std::vector<std::vector<Vec2>> places;  ///< by peer, by entity
  };
  void sample();
  void measure_fidelity();
  void measure_delayed();

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
};

}  // namespace padr::lab::alternatives
