#include "tests/bench/party.h"

#include <cmath>

#include "common/link/netem_spec.h"
#include "common/model/rng.h"
#include "common/scenarios/scenarios.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "tests/bench/allocations.h"

namespace padr::bench {

double seconds_of_looking() {
  std::vector<double> looks(1001);
  for (double& seconds : looks) {
    const double start = processor_seconds();
    seconds = processor_seconds() - start;
  }
  std::nth_element(looks.begin(), looks.begin() + 500, looks.end());
  return looks[500];
}

Scene room(int bodies, int spawns) {
  const double height = std::max(6.0, std::sqrt(bodies * 5.0 * 3 / 4));
  const double width = height * 4 / 3;
  const auto text = [](double v) { return std::to_string(v); };
  std::string s = "name: 'room' title: 'A room' lower { x: 0 y: 0 } upper { x: " + text(width) + " y: " + text(height) +
                  " } avatar { radius: 0.4 mass: 80 stiffness: 40 damping: 10 max_force: 1600 max_speed: 6";
  // Evenly along the walls.
  const double inset = 1;
  const double around = 2 * (width + height - 4 * inset);
  for (int i = 0; i < spawns; ++i) {
    double at = around * i / spawns;
    double x = inset;
    double y = inset;
    for (const auto& [dx, dy, length] : {std::tuple{1, 0, width - 2 * inset},
                                         {0, 1, height - 2 * inset},
                                         {-1, 0, width - 2 * inset},
                                         {0, -1, height - 2 * inset}}) {
      const double part = std::clamp(at, 0.0, length);
      x += dx * part;
      y += dy * part;
      at -= part;
    }
    s += " spawn { x: " + text(x) + " y: " + text(y) + " }";
  }
  s += " } walls { thickness: 2 } material { friction: 0.3 restitution: 0.2 linear_damping: 1.2 angular_damping: 1.5 }"
       " scatter { count: " +
       std::to_string(bodies) +
       " margin: 0.2 gap: 0.1 spawn_clearance: 0.5 kind { radius { min: 0.2 max: 0.5 } density { min: 35 max: 45 } }"
       " kind { box { half_width { min: 0.2 max: 0.5 } half_height { min: 0.2 max: 0.5 } } density { min: 32 max: 40 }"
       " angle { min: 0 max: 3.1415927 } } }";
  return scenarios::load(s, "room", 1);
}

Scene restless_room(int bodies, int spawns) {
  Scene scene = room(bodies, spawns);
  Rng rng(1);
  for (BodyDef& b : scene.bodies) {
    b.friction = 0;
    b.restitution = 1;
    b.linear_damping = b.angular_damping = 0;
    const double direction = rng.uniform(0, 6.283);
    b.velocity = Vec2{static_cast<float>(std::cos(direction)), static_cast<float>(std::sin(direction))} * 2.0F;
  }
  for (BodyDef& b : scene.statics) b.restitution = 1;
  return scene;
}

Mesh::Mesh(const Scene& scene, int peers, const std::string& netem, const std::string& input, std::uint64_t seed) {
  const link::NetemSpec spec = shell::parse_netem(netem);
  for (int p = 0; p < peers; ++p) {
    node::ReplicaConfig c;
    c.self = static_cast<PeerId>(p);
    c.peers = c.slots = peers;
    nodes.push_back(std::make_unique<node::Replica>(scene, c));
    inputs.push_back(shell::make_input(input, {scene, p, seed, {}}));
    auto& row = shims.emplace_back();
    for (int q = 0; q < peers; ++q)
      row.push_back(std::make_unique<link::Shim>(
          spec, derive_seed(seed, static_cast<std::uint64_t>(p), static_cast<std::uint64_t>(q))));
  }
}

std::vector<std::vector<std::byte>> Party::arrived(std::size_t at) {
  std::vector<std::vector<std::byte>> all;
  for (std::size_t from = 0; from < mesh_.nodes.size(); ++from)
    while (auto d = mesh_.shims[from][at]->release(tick_start(now_))) all.push_back(std::move(*d));
  return all;
}

Party::Frame Party::frame(std::size_t p) {
  const auto datagrams = arrived(p);
  const Vec2 target = mesh_.inputs[p]->target(now_);
  Frame f;
  f.datagrams = datagrams.size();
  const std::uint64_t before = allocations();
  f.seconds = seconds_of([&] {
    for (const auto& d : datagrams) mesh_.nodes[p]->receive(d, tick_start(now_));
    mesh_.nodes[p]->step(target);
  });
  f.allocations = allocations() - before;
  for (const node::Outgoing& o : mesh_.nodes[p]->outgoing()) mesh_.shims[p][o.to]->accept(tick_start(now_), o.bytes);
  return f;
}

Party::Frame Party::tick() {
  ++now_;
  const Frame first = frame(0);
  for (std::size_t p = 1; p < mesh_.nodes.size(); ++p) frame(p);
  return first;
}

}  // namespace padr::bench
