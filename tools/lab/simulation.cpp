#include "tools/lab/simulation.h"

#include <algorithm>
#include <numeric>

#include "common/trace/truth.h"

namespace padr::lab {
Simulation::Simulation(SimulationConfig config)
    : config_(std::move(config)),
      links_(config_.netem, config_.netem_seed),
      meter_(config_.peers, static_cast<int>(config_.scene.bodies.size())),
      flips_(static_cast<int>(config_.scene.bodies.size())) {
  const auto n = static_cast<std::size_t>(config_.peers);
  hashes_.resize(n);
  live_hashes_.resize(n);
  stands_.resize(n);
  targets_.resize(n);
  states_.resize(n);
  player_views_.resize(n);
  const int slots = config_.slots > 0 ? config_.slots : config_.peers;
  shown_.assign(n, trace::ShownMeter(config_.scene, slots));
  if (config_.fidelity) {
    std::vector<PeerId> viewers(n);
    std::iota(viewers.begin(), viewers.end(), PeerId{0});
    fidelity_ = std::make_unique<trace::FidelityMeter>(config_.scene, slots, std::move(viewers));
  }
  if (config_.processor_time)
    processor_time_ = std::make_unique<ProcessorTime>(config_.scene, config_.slots > 0 ? config_.slots : config_.peers);
  for (PeerId p = 0; p < n; ++p) {
    node::ReplicaConfig c;
    c.self = p;
    c.peers = config_.peers;
    c.slots = slots;
    c.session = 1;
    c.technique = config_.technique;
    const bool authority = config_.technique.authority;
    nodes_.push_back(std::make_unique<node::RecordedReplica>(
        config_.scene, c, p < config_.recordings.size() ? std::move(config_.recordings[p]) : std::nullopt,
        [this, p, authority](const sync::FoldState& s, std::uint64_t hash) {
          const ProcessorTime::Pause pause(processor_time_.get());
          hashes_[p].push_back(hash);
          if (config_.on_confirmed) config_.on_confirmed(p, s);
          if (p != 0) return;
          trace::take_truth(s, authority, truth_);
          flips_.owners(s.tick, truth_.owner);
          meter_.truth(s.tick, truth_);
          if (config_.settle_ticks > 0) agreed_hashes_.push_back(node::state_hash(s));
        }));
  }
  sample_views();
}

Simulation::~Simulation() = default;

void Simulation::run(const std::function<void(Tick)>& on_tick) {
  while (now_ < config_.ticks + config_.settle_ticks) {
    step();
    if (on_tick) on_tick(now_);
  }
}

void Simulation::work() {
  const Micros now = tick_start(now_);
  links_.deliver(now, [&](std::size_t /*from*/, std::size_t to, Micros /*when*/, const auto& datagram) {
    nodes_[to]->receive(datagram, now);
  });
  for (PeerId p = 0; p < nodes_.size(); ++p) nodes_[p]->step(targets_[p]);
}

void Simulation::step() {
  ++now_;
  for (PeerId p = 0; p < nodes_.size(); ++p) targets_[p] = target_of(p);
  if (processor_time_) processor_time_->begin();
  work();
  if (processor_time_) {
    processor_time_->end();
    processor_time_->step_bare(targets_);
  }
  for (PeerId p = 0; p < nodes_.size(); ++p)
    for (const node::Outgoing& o : nodes_[p]->outgoing()) links_.send(p, o.to, tick_start(now_), o.bytes);
  sample_views();
  compare_confirmed();
}

Vec2 Simulation::target_of(PeerId p) {
  if (now_ <= config_.ticks) return config_.inputs[p]->target(now_);
  constexpr float kStopped = 0.05F;  // m/s
  const world::View& live = replica(p).live().world();
  const EntityId avatar = replica(p).live().avatar();
  if (!stands_[p] && length(live.velocity(avatar)) < kStopped) stands_[p] = live.position(avatar);
  return stands_[p].value_or(live.position(avatar));
}

void Simulation::sample_views() {
  for (PeerId p = 0; p < nodes_.size(); ++p) {
    const world::View& w = replica(p).live().world();
    view_.live.clear();
    for (const world::Kinematics& k : w.kinematics()) view_.live.push_back(k.position);
    view_.unowned_alone = plays_unowned_alone(replica(p).config().technique);
    view_.shown = now_ == 0 ? view_.live : replica(p).shown().positions();
    meter_.view(p, now_, view_);
    sample_shown(p);
    if (config_.settle_ticks > 0) live_hashes_[p].push_back(replica(p).live_hash());
  }
  if (fidelity_) sample_fidelity();
}

void Simulation::sample_shown(PeerId p) {
  const world::View& w = replica(p).live().world();
  states_[p].clear();
  present_.clear();
  for (EntityId e = 0; e < w.entities(); ++e) {
    states_[p].push_back(w.state(e));
    present_.push_back(w.present(e));
  }
  shown_[p].tick(states_[p], view_.shown, present_);
}

void Simulation::sample_fidelity() {
  for (PeerId p = 0; p < nodes_.size(); ++p) player_views_[p] = {true, states_[p], targets_[p]};
  fidelity_->tick(now_, player_views_);
}

trace::InconsistencySeries Simulation::seen_with_input(PeerId p) const {
  trace::InconsistencySeries seen;
  for (const trace::InconsistencyPoint& point : meter_.series(p))
    if (point.tick >= 1 && point.tick <= config_.ticks) seen.push_back(point);
  return seen;
}

void Simulation::compare_confirmed() {
  std::size_t all = hashes_[0].size();
  for (const auto& h : hashes_) all = std::min(all, h.size());
  for (; compared_ < all; ++compared_) {
    for (const auto& h : hashes_) {
      if (h[compared_] == hashes_[0][compared_]) continue;
      ++mismatches_;
      if (first_mismatch_ < 0) first_mismatch_ = static_cast<Tick>(compared_);
      break;
    }
    if (config_.settle_ticks == 0) continue;
    for (const auto& h : live_hashes_)
      if (h[compared_] != agreed_hashes_[compared_]) last_unlike_ = static_cast<Tick>(compared_);
  }
}

double Simulation::measured_share() const {
  return static_cast<double>(hashes_[0].size()) / static_cast<double>(std::max(1, now_));
}

void Simulation::finish() {
  for (const auto& n : nodes_) n->finish();
}

}  // namespace padr::lab
