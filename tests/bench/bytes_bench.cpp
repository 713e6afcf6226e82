// What play takes on the wire: peers wander in a scenario on links that delay and lose a little, for a minute, and
// every state datagram is looked into.
//
//   datagram   mean bytes of one, IP and UDP headers included
//   kbit_s     of one directed link, the same included
//   avatar     bytes of the floats of an avatar's update
//   body       bytes of an update of a body with state, all that it adds to its datagram
//   of_raw     that over its floats, 24 bytes of a moving body and 12 of a resting one
//   of_dis     that over an Entity State PDU of IEEE 1278.1, 144 bytes
//   based      share of these for which the receiver is known to have an earlier state by the same sender
//   avatar_d, body_d   the same bytes if floats were told as differences to such states where that is shorter
//
// A difference is to the earlier state moved on by its velocity, of the floats' bits in their order as numbers, zigzag
// and varint: as exact as the floats. It saves little, as an update is only sent when what was known has turned out
// wrong; hence there are none on the wire.
#include <benchmark/benchmark.h>

#include <bit>
#include <map>
#include <string>
#include <vector>

#include "common/scenarios/scenarios.h"
#include "common/wire/codec.h"
#include "tests/bench/party.h"

namespace padr::bench {
namespace {

constexpr Tick kPlayed = 60 * kTicksPerSecond;
constexpr double kIpUdpBytes = 28;
constexpr double kPduBytes = 144;
/// A base is one of so many updates before.
constexpr std::uint32_t kBases = 256;

/// Position, velocity and what else there is, with what they are predicted to be.
struct Told {
  std::uint32_t index = 0;
  Tick tick = 0;
  std::vector<float> values;
  std::vector<float> rates;  ///< by which they change a second
};

/// The bits as a number that ascends with the float.
std::uint32_t ordinal(float v) {
  const auto bits = std::bit_cast<std::uint32_t>(v);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

double difference_bytes(const Told& t, const Told& base) {
  double bytes = 0;
  for (std::size_t i = 0; i < t.values.size(); ++i) {
    const double seconds = static_cast<double>(t.tick - base.tick) / kTicksPerSecond;
    const auto expected = static_cast<float>(static_cast<double>(base.values[i]) + base.rates[i] * seconds);
    const auto d = static_cast<std::int32_t>(ordinal(t.values[i]) - ordinal(expected));
    for (auto z = (static_cast<std::uint32_t>(d) << 1U) ^ static_cast<std::uint32_t>(d >> 31); z >= 0x80; z >>= 7U)
      ++bytes;
    ++bytes;
  }
  return bytes;
}

Told told(const sync::AvatarUpdate& u) {
  Told t{0, 0, {u.position.x, u.position.y, u.velocity.x, u.velocity.y}, {u.velocity.x, u.velocity.y, 0, 0, 0, 0}};
  if (u.model == Model::kSecond || u.model == Model::kInput)
    t.values.insert(t.values.end(), {u.control.x, u.control.y});
  return t;
}

Told told(const BodyState& s) {
  Told t{0, 0, {s.position.x, s.position.y, s.angle}, {s.velocity.x, s.velocity.y, s.spin, 0, 0, 0}};
  if (s.awake) t.values.insert(t.values.end(), {s.velocity.x, s.velocity.y, s.spin});
  return t;
}

/// All that one sender has told of its entities; the avatar goes by kNoEntity.
class History {
 public:
  /// Bytes of the floats raw, and as a difference if the receiver has all updates below `acked`.
  struct Size {
    double raw = 0;
    double best = 0;
    bool based = false;
  };
  Size note(EntityId e, Told t, const sync::Bundle& b, std::uint32_t acked) {
    t.index = b.index;
    t.tick = b.tick;
    std::vector<Told>& all = told_[e];
    const auto raw = static_cast<double>(t.values.size() * sizeof(float));
    Size s{raw, raw, false};
    for (auto base = all.rbegin(); base != all.rend() && !s.based; ++base) {
      if (base->index >= std::min(acked, t.index) || base->index + kBases < t.index) continue;
      if (base->values.size() < t.values.size()) break;
      s.based = true;
      s.best = std::min(raw, difference_bytes(t, *base));
    }
    if (all.empty() || all.back().index < t.index) all.push_back(std::move(t));
    return s;
  }

 private:
  std::map<EntityId, std::vector<Told>> told_;
};

struct Sums {
  double datagrams = 0, bytes = 0;
  double avatars = 0, avatar_raw = 0, avatar_best = 0;
  double bodies = 0, body_bytes = 0, body_raw = 0, body_best = 0, based = 0;
};

double size_of(sync::StatePacket p, const sync::Bundle& b) {
  p.updates = {b};
  return static_cast<double>(wire::encode(p).size());
}

void look_into(const sync::StatePacket& p, std::uint32_t acked, History& history, Sums& s) {
  for (const sync::Bundle& b : p.updates) {
    if (b.avatar) {
      const History::Size a = history.note(kNoEntity, told(*b.avatar), b, acked);
      ++s.avatars;
      s.avatar_raw += a.raw;
      s.avatar_best += a.best;
    }
    sync::Bundle without = b;
    std::erase_if(without.bodies, [](const sync::BodyUpdate& u) { return u.has_state; });
    s.body_bytes += size_of(p, b) - size_of(p, without);
    for (const sync::BodyUpdate& u : b.bodies) {
      if (!u.has_state) continue;
      const History::Size body = history.note(u.body, told(u.state), b, acked);
      ++s.bodies;
      s.body_raw += body.raw;
      s.body_best += body.best;
      s.based += body.based ? 1 : 0;
    }
  }
}

/// Peers on links that are all alike.
class Play {
 public:
  Play(const Scene& scene, int peers, const std::string& netem)
      : mesh_(scene, peers, netem, "wander", 1), histories_(static_cast<std::size_t>(peers)) {}

  void tick(Sums& sums) {
    const Micros now = tick_start(++now_);
    for (auto& row : mesh_.shims)
      for (std::size_t to = 0; to < mesh_.nodes.size(); ++to)
        while (auto d = row[to]->release(now)) mesh_.nodes[to]->receive(*d, now);
    for (std::size_t p = 0; p < mesh_.nodes.size(); ++p) {
      mesh_.nodes[p]->step(mesh_.inputs[p]->target(now_));
      for (const node::Outgoing& o : mesh_.nodes[p]->outgoing()) {
        ++sums.datagrams;
        sums.bytes += static_cast<double>(o.bytes.size()) + kIpUdpBytes;
        wire::SealError error{};
        const auto opened = wire::open(o.bytes, error);
        const sync::StatePacket* packet = decoder_.decode(opened->payload, static_cast<PeerId>(p));
        look_into(*packet, mesh_.nodes[p]->link(o.to).out.acked(), histories_[p], sums);
        mesh_.shims[p][o.to]->accept(now, o.bytes);
      }
    }
  }

 private:
  Tick now_ = 0;
  Mesh mesh_;
  std::vector<History> histories_;
  wire::StateDecoder decoder_;
};

void play(benchmark::State& state, const char* scenario, int peers, const char* netem) {
  Sums s;
  for (auto unused : state) {
    (void)unused;
    Play all(scenarios::load_embedded(scenario, 1), peers, netem);
    while (s.datagrams == 0) all.tick(s);
    s = {};
    for (Tick t = 0; t < kPlayed; ++t) all.tick(s);
  }
  const double links = peers * (peers - 1);
  state.counters["datagram"] = s.bytes / s.datagrams;
  state.counters["kbit_s"] = s.bytes * 8 / 1000 / links * kTicksPerSecond / kPlayed;
  state.counters["avatar"] = s.avatar_raw / s.avatars;
  state.counters["avatar_d"] = s.avatar_best / s.avatars;
  state.counters["body"] = s.body_bytes / s.bodies;
  state.counters["body_d"] = (s.body_bytes - s.body_raw + s.body_best) / s.bodies;
  state.counters["of_raw"] = s.body_bytes / s.body_raw;
  state.counters["of_dis"] = s.body_bytes / s.bodies / kPduBytes;
  state.counters["based"] = s.based / s.bodies;
}

void for_a_minute(benchmark::internal::Benchmark* b) {
  b->Iterations(1)->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(play, arena_2, "arena", 2, "delay 50ms 10ms")->Apply(for_a_minute);
BENCHMARK_CAPTURE(play, arena_4_lossy, "arena", 4, "delay 100ms 50ms loss 10%")->Apply(for_a_minute);
BENCHMARK_CAPTURE(play, clutter_4, "clutter", 4, "delay 50ms 10ms loss 1%")->Apply(for_a_minute);

}  // namespace
}  // namespace padr::bench
