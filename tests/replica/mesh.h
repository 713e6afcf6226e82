#pragma once

#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "common/link/link_mesh.h"
#include "common/replica/replica.h"
#include "common/scenarios/scenarios.h"
#include "common/session/view.h"
#include "shell/netem_text.h"

namespace padr::node {

/// Nodes on a network that the test can pull at.
class Mesh {
 public:
  Mesh(int peers, const char* netem, std::uint64_t seed, const Technique& technique = {},
       const char* scenario = "arena", const sync::Fault& of_peer_0 = {})
      : scene_(scenarios::load_embedded(scenario, 1)), links_(shell::parse_netem(netem), seed) {
    for (PeerId p = 0; p < peers; ++p) {
      ReplicaConfig c;
      c.self = p;
      c.peers = c.slots = peers;
      c.technique = technique;
      if (p == 0) c.fault = of_peer_0;
      nodes_.push_back(std::make_unique<Replica>(scene_, c));
    }
  }

  /// From now on everybody goes to where it is to stay.
  void settle() { still_ = true; }
  void wake() { still_ = false; }

  void step(const std::vector<bool>& running) {
    ++now_;
    const Micros t = tick_start(now_);
    links_.deliver(t, [&](std::size_t /*from*/, std::size_t to, Micros /*when*/, const auto& datagram) {
      if (running[to]) nodes_[to]->receive(datagram, t);
    });
    for (PeerId p = 0; p < nodes_.size(); ++p) {
      if (!running[p]) continue;
      const Tick move = still_ ? 0 : now_ / 40;
      nodes_[p]->step({10.0F + 4.0F * static_cast<float>((move + p) % 3), 7.0F + static_cast<float>(p)});
      for (const Outgoing& o : nodes_[p]->outgoing()) links_.send(p, o.to, t, o.bytes);
    }
  }
  Replica& operator[](PeerId p) { return *nodes_[p]; }
  const Replica& operator[](PeerId p) const { return *nodes_[p]; }
  Tick now() const { return now_; }

 private:
  Scene scene_;
  std::vector<std::unique_ptr<Replica>> nodes_;
  link::LinkMesh links_;
  Tick now_ = 0;
  bool still_ = false;
};

}  // namespace padr::node
