#include "tools/lab/convergence/footage.h"

#include <algorithm>

namespace padr::lab::convergence {

Takes::Takes(const SimulationConfig& config, PeerId viewer) : ticks_(config.ticks) {
  footage.viewer = viewer;
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    SimulationConfig c;
    c.scene = config.scene;
    c.peers = config.peers;
    c.technique = config.technique;
    c.technique.convergence = kMethods[m];
    c.netem = config.netem;
    c.netem_seed = config.netem_seed;
    c.inputs = config.inputs;
    c.ticks = config.ticks;
    simulations[m] = std::make_unique<Simulation>(std::move(c));
  }
}

void Takes::run() {
  while (simulations.front()->now() < ticks_) {
    for (const auto& s : simulations) s->step();
    film();
  }
}

void Takes::film() {
  for (std::size_t m = 0; m < kMethods.size(); ++m)
    footage.shown[m].push_back(simulations[m]->replica(footage.viewer).shown().positions());
  const Simulation& s = *simulations.front();
  const node::Replica& viewer = s.replica(footage.viewer);
  const world::View& seen = viewer.live().world();
  const std::vector<sync::Authority>& authority = viewer.agreed().predicted_state().authority;
  Footage::Positions truth;
  std::vector<float> angles;
  std::vector<bool> foreign;
  for (EntityId e = 0; e < seen.entities(); ++e) {
    const PeerId owner = e < seen.bodies() ? authority[e].holder() : static_cast<PeerId>(e - seen.bodies());
    foreign.push_back(owner != footage.viewer && owner != kNoPeer);
    angles.push_back(seen.state(e).angle);
    truth.push_back((foreign.back() ? s.replica(owner).live().world() : seen).position(e));
  }
  footage.truth.push_back(std::move(truth));
  footage.angles.push_back(std::move(angles));
  footage.foreign.push_back(std::move(foreign));
}

Moment largest_correction(const Footage& f, int bodies, bool of_body, float most, Tick before, Tick after) {
  Moment best;
  const auto& snapped = f.shown.front();
  const auto ticks = static_cast<Tick>(snapped.size());
  const auto anothers = [&](EntityId e, Tick from, Tick to) {
    for (Tick t = from; t < to; ++t)
      if (!f.foreign[static_cast<std::size_t>(t)][e]) return false;
    return true;
  };
  for (Tick t = std::max<Tick>(before, 2); t + after < ticks; ++t) {
    const auto i = static_cast<std::size_t>(t);
    for (EntityId e = 0; e < snapped[i].size(); ++e) {
      if ((e < bodies) != of_body) continue;
      const Vec2 went_on = snapped[i - 1][e] + (snapped[i - 1][e] - snapped[i - 2][e]);
      const float metres = distance(snapped[i][e], went_on);
      if (metres > best.metres && metres <= most && anothers(e, t - before, t + after)) best = {t, e, metres};
    }
  }
  return best;
}

}  // namespace padr::lab::convergence
