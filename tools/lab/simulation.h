#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/link/link_mesh.h"
#include "common/replica/recorded_replica.h"
#include "common/scenarios/input.h"
#include "common/trace/fidelity.h"
#include "common/trace/flips.h"
#include "common/trace/metrics.h"
#include "common/trace/shown_meter.h"
#include "tools/lab/measure/processor_time.h"

namespace padr::lab {

struct SimulationConfig {
  Scene scene;
  int peers = 2;
  int slots = 0;  ///< avatar slots; 0: as many as peers
  Technique technique;
  link::NetemSpec netem;  ///< of every directed link
  std::uint64_t netem_seed = 1;
  std::vector<scenarios::InputSource*> inputs;                              ///< by peer; not owned
  std::vector<std::optional<node::RecordedReplica::Recording>> recordings;  ///< by peer; empty: none is recorded
  Tick ticks = 0;                                                           ///< with input
  /// Afterwards, hands off: every avatar brakes, and then stands where it has stopped. Time to come to rest and to
  /// agree.
  Tick settle_ticks = 0;
  /// Whether fidelity and physics-consistency-cost are measured, which may take a step of another world per peer and
  /// tick.
  bool fidelity = false;
  bool processor_time = false;  ///< whether it is measured
  /// Sees every confirmed state of every peer; may be empty.
  std::function<void(PeerId, const sync::FoldState&)> on_confirmed = {};
};

/// N nodes in lock step on a virtual clock, every directed link through a shim.
class Simulation {
 public:
  explicit Simulation(SimulationConfig config);
  ~Simulation();

  /// Runs all ticks; `on_tick`, if given, is called after each.
  void run(const std::function<void(Tick)>& on_tick = {});
  /// One tick.
  void step();
  /// Ends the traces, if any; no step may follow.
  void finish();
  /// As Replica::retune, before the next step.
  void retune(PeerId p, const Technique& technique) { nodes_[p]->retune(technique); }

  Tick now() const { return now_; }
  int peers() const { return config_.peers; }
  const node::Replica& replica(PeerId p) const { return nodes_[p]->replica(); }
  const trace::InconsistencyMeter& meter() const { return meter_; }
  /// What this peer alone has seen, at the ticks with input alone.
  trace::InconsistencySeries seen_with_input(PeerId p) const;
  /// Null if it was not asked for.
  const trace::FidelityMeter* fidelity() const { return fidelity_.get(); }
  /// Null if it was not asked for.
  const ProcessorTime* processor_time() const { return processor_time_.get(); }
  /// How what this peer is shown moves.
  const trace::ShownMotion& shown(PeerId p) const { return shown_[p].result(); }
  /// Of the first peer's confirmed world.
  const trace::FlipMeter& flips() const { return flips_; }

  /// Confirmed ticks that every peer has reached and whose hashes have been compared.
  std::uint64_t confirmed_ticks() const { return compared_; }
  /// Of the ticks played so far, those at which inconsistency was measured, 0 to 1: peer 0 has confirmed them.
  double measured_share() const;
  /// Whether such a share of so many ticks is worth a warning: inconsistency is then that of the beginning.
  static bool is_little(double measured_share, Tick ticks) {
    return measured_share < 0.9 && (1 - measured_share) * ticks > 2 * kTicksPerSecond;
  }
  /// Hash of the last of them.
  std::uint64_t last_confirmed_hash() const { return hashes_[0][compared_ - 1]; }
  /// Those among them at which not all hashes were the same.
  std::uint64_t confirmed_mismatches() const { return mismatches_; }
  /// The first of them, -1 if none.
  Tick first_mismatch() const { return first_mismatch_; }
  /// The last confirmed tick at which some peer's live world was not, state by state and bit by bit, the confirmed
  /// world of that tick; -1 if there is none, or nothing was to settle. Once input has stopped and everything has come
  /// to rest, it stays behind.
  Tick last_unlike() const { return last_unlike_; }

 private:
  void work();
  void compare_confirmed();
  void sample_views();
  void sample_shown(PeerId p);
  void sample_fidelity();
  Vec2 target_of(PeerId p);

  SimulationConfig config_;
  Tick now_ = 0;
  std::vector<std::unique_ptr<node::RecordedReplica>> nodes_;
  std::vector<std::optional<Vec2>> stands_;  ///< by peer: where its avatar stopped after the end of input
  link::LinkMesh links_;
  std::vector<std::vector<std::uint64_t>> hashes_;  ///< by peer: of every confirmed tick
  trace::View view_;                                ///< these two: memory that is used again
  trace::Truth truth_;
  trace::InconsistencyMeter meter_;
  trace::FlipMeter flips_;
  std::vector<trace::ShownMeter> shown_;  ///< by peer
  std::unique_ptr<trace::FidelityMeter> fidelity_;
  std::unique_ptr<ProcessorTime> processor_time_;
  std::vector<Vec2> targets_;                    ///< by peer, of the last step
  std::vector<std::vector<BodyState>> states_;   ///< by peer, of its live world
  std::vector<bool> present_;                    ///< by entity; memory that is used again
  std::vector<trace::PlayerView> player_views_;  ///< by peer
  std::uint64_t compared_ = 0;
  std::uint64_t mismatches_ = 0;
  Tick first_mismatch_ = -1;
  std::vector<std::vector<std::uint64_t>> live_hashes_;  ///< by peer: of every tick
  std::vector<std::uint64_t> agreed_hashes_;             ///< of the first peer's confirmed states
  Tick last_unlike_ = -1;
};

}  // namespace padr::lab
