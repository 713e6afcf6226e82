#include "tests/fights/fight.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "shell/netem_text.h"

namespace padr::test {
namespace {

constexpr float kLeap = 2.9F;  // m

class Scripted : public scenarios::InputSource {
 public:
  explicit Scripted(Script script) : script_(std::move(script)) {}
  Vec2 target(Tick tick) override { return script_(static_cast<double>(tick) / kTicksPerSecond); }

 private:
  Script script_;
};

bool finite(const BodyState& s) {
  return std::isfinite(s.position.x) && std::isfinite(s.position.y) && std::isfinite(s.angle) &&
         std::isfinite(s.velocity.x) && std::isfinite(s.velocity.y) && std::isfinite(s.spin);
}

/// Looks at confirmed worlds as they come to be known, peer by peer.
class ConfirmedWatcher {
 public:
  ConfirmedWatcher(std::size_t bodies, Outcome& out) : out_(out), last_takeover_(bodies, -1), owner_(bodies, kNoPeer) {}

  bool all_held(int peers) const { return held_ == (PeerSet{1} << static_cast<unsigned>(peers)) - 1; }

  void see(PeerId, const sync::FoldState& s) {
    for (std::size_t b = 0; b < owner_.size(); ++b) {
      const world::Kinematics& k = s.world.entities[b];
      out_.finite = out_.finite && finite({k.position, k.angle, k.velocity, k.spin, k.awake});
      out_.fastest_body = std::max(out_.fastest_body, length(k.velocity));
    }
    for (const PeerSet h : s.holds) held_ |= h;
    std::vector<PeerId> owners;
    for (const sync::Authority& a : s.authority) owners.push_back(a.holder());
    const auto [first, fresh] = by_tick_.try_emplace(s.tick, owners);
    if (!fresh) {
      for (std::size_t b = 0; b < owners.size(); ++b) out_.differing_owners += owners[b] != first->second[b] ? 1U : 0U;
      return;
    }
    for (std::size_t b = 0; b < owners.size(); ++b) count(b, owners[b], s.tick);
  }

 private:
  void count(std::size_t b, PeerId now, Tick tick) {
    if (now != owner_[b] && now != kNoPeer && owner_[b] != kNoPeer) {
      if (last_takeover_[b] >= 0) out_.closest_takeovers = std::min(out_.closest_takeovers, tick - last_takeover_[b]);
      last_takeover_[b] = tick;
    } else if (now != owner_[b]) {
      last_takeover_[b] = -1;  // let go of, or taken from nobody: no contest
    }
    owner_[b] = now;
  }

  Outcome& out_;
  PeerSet held_ = 0;  ///< of the peers whose avatar has held something
  std::map<Tick, std::vector<PeerId>> by_tick_;
  std::vector<Tick> last_takeover_;
  std::vector<PeerId> owner_;
};

/// Looks at live worlds and at what is shown of them, tick by tick.
class FightWatcher {
 public:
  FightWatcher(const lab::Simulation& s, const Scene& scene, Outcome& out) : s_(s), scene_(scene), out_(out) {
    const auto entities = static_cast<std::size_t>(s.replica(0).live().world().entities());
    const auto peers = static_cast<std::size_t>(s.peers());
    before_.assign(peers, std::vector<Vec2>(entities));
    shown_.assign(peers, {});
    stride_.assign(peers, std::vector<Vec2>(entities));
    overlapped_.assign(peers, std::vector<Tick>(scene.bodies.size(), 0));
    disputed_.assign(scene.bodies.size(), 0);
  }

  void see(Tick t) {
    for (PeerId p = 0; p < s_.peers(); ++p) {
      const world::View& live = s_.replica(p).live().world();
      for (EntityId b = 0; b < scene_.bodies.size(); ++b) body(p, b, live);
      jumps(p, t);
    }
    for (EntityId b = 0; b < scene_.bodies.size(); ++b) disputes(b);
  }

 private:
  void body(PeerId p, EntityId b, const world::View& live) {
    const BodyState s = live.state(b);
    out_.finite = out_.finite && finite(s);
    out_.fastest_body = std::max(out_.fastest_body, length(s.velocity));
    const float depth =
        scene_.bodies[b].radius + scene_.avatar.radius - distance(s.position, live.position(live.avatar(p)));
    out_.deepest = std::max(out_.deepest, depth);
    Tick& on_end = overlapped_[p][b];
    on_end = depth > 0.05F ? on_end + 1 : 0;
    out_.longest_overlap = std::max(out_.longest_overlap, on_end);
    if (mine(p, b)) {
      const float beyond = length(s.position - before_[p][b] - s.velocity * kTickSeconds);
      if (was_mine_.contains({p, b})) out_.farthest_push_out = std::max(out_.farthest_push_out, beyond);
      was_mine_.insert({p, b});
    } else {
      was_mine_.erase({p, b});
    }
    before_[p][b] = s.position;
  }

  bool mine(PeerId p, EntityId b) const { return s_.replica(p).agreed().predicted_state().authority[b].holder() == p; }

  // What the own avatar hits moves by that, before it is known to be the own.
  bool pushed(PeerId p, EntityId b, const world::View& live) const {
    const float apart = distance(live.position(b), live.position(live.avatar(p)));
    return apart < scene_.bodies[b].radius + scene_.avatar.radius + length(live.velocity(b)) * kTickSeconds;
  }

  void jumps(PeerId p, Tick t) {
    const std::vector<Vec2>& now = s_.replica(p).shown().positions();
    const world::View& live = s_.replica(p).live().world();
    for (EntityId e = 0; e < shown_[p].size(); ++e) {
      const Vec2 stride = now[e] - shown_[p][e];
      const Vec2 last = std::exchange(stride_[p][e], stride);
      if (e == live.avatar(p) || (e < live.bodies() && (mine(p, e) || pushed(p, e, live)))) continue;
      const float jump = distance_to_segment(stride, live.velocity(e) * kTickSeconds, last);
      if (jump > kLeap) ++out_.leaps;
      if (jump > kLeap || jump <= out_.largest_foreign_jump) continue;
      out_.largest_foreign_jump = jump;
      out_.largest_jump_where =
          "entity " + std::to_string(e) + " at peer " + std::to_string(p) + ", tick " + std::to_string(t);
    }
    shown_[p] = now;
  }

  void disputes(EntityId b) {
    int owners = 0;
    for (PeerId p = 0; p < s_.peers(); ++p) owners += mine(p, b) ? 1 : 0;
    disputed_[b] = owners > 1 ? disputed_[b] + 1 : 0;
    out_.longest_dispute = std::max(out_.longest_dispute, disputed_[b]);
  }

  const lab::Simulation& s_;
  const Scene& scene_;
  Outcome& out_;
  std::vector<std::vector<Vec2>> before_;      ///< by peer, entity: live, m
  std::vector<std::vector<Vec2>> shown_;       ///< by peer, entity, m
  std::vector<std::vector<Vec2>> stride_;      ///< by peer, entity, m in the last tick
  std::vector<std::vector<Tick>> overlapped_;  ///< by peer, body: ticks on end
  std::vector<Tick> disputed_;                 ///< by body: ticks on end
  std::set<std::pair<PeerId, EntityId>> was_mine_;
};

}  // namespace

Outcome fight(const Arena& arena, const std::string& netem, std::uint64_t seed, const Technique& technique) {
  constexpr int kSettleSeconds = 15;
  Outcome out;
  ConfirmedWatcher confirmed(arena.scene.bodies.size(), out);
  std::vector<Scripted> inputs;
  inputs.reserve(arena.scripts.size());
  lab::SimulationConfig c;
  c.scene = arena.scene;
  c.peers = static_cast<int>(arena.scripts.size());
  c.technique = technique;
  c.netem = shell::parse_netem(netem);
  c.netem_seed = seed;
  c.ticks = static_cast<Tick>(arena.seconds * kTicksPerSecond);
  c.settle_ticks = kSettleSeconds * kTicksPerSecond;
  for (const Script& s : arena.scripts) c.inputs.push_back(&inputs.emplace_back(s));
  c.on_confirmed = [&confirmed](PeerId p, const sync::FoldState& s) { confirmed.see(p, s); };
  out.closest_takeovers = c.ticks;
  lab::Simulation simulation(std::move(c));
  FightWatcher watcher(simulation, arena.scene, out);
  simulation.run([&watcher](Tick t) { watcher.see(t); });
  out.confirmed_ticks = simulation.confirmed_ticks();
  out.differing_worlds = simulation.confirmed_mismatches();
  out.hand_overs = simulation.flips().all();
  out.rests_alike = simulation.last_unlike() < static_cast<Tick>(out.confirmed_ticks) - kTicksPerSecond;
  out.fought = confirmed.all_held(simulation.peers());
  return out;
}

}  // namespace padr::test
