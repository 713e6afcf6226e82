// What a datagram costs besides physics: encoding, reading and judging it, a link's shim; and what an update takes on
// the wire, beside what it cannot go below without being coded against something known, and beside DIS.
//
//   ns, allocs   of one datagram
//   bytes        of one body update on the wire, besides what its datagram has anyway
//   of_raw       that over the 24 bytes of its floats: position, angle, velocity, spin
//   of_dis       that over an Entity State PDU of IEEE 1278.1, 144 bytes
#include <benchmark/benchmark.h>

#include "common/link/shim.h"
#include "common/model/precision.h"
#include "common/model/rng.h"
#include "common/sync/validation.h"
#include "common/wire/codec.h"
#include "shell/netem_text.h"
#include "tests/bench/allocations.h"
#include "tests/bench/party.h"

namespace padr::bench {
namespace {

constexpr int kBatch = 256;
constexpr double kRawBytes = 24;
constexpr double kDisBytes = 144;

float any(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}

/// What an avatar tells when it begins to push so many bodies.
sync::StatePacket packet(const Scene& scene, int bodies, Precision precision = Precision::kRounded) {
  Rng rng(1);
  sync::StatePacket p;
  p.seq = 5000;
  p.mark_tick = 72000;
  p.mark_count = 4000;
  p.have = 3900;
  p.seen_seq = 4990;
  sync::Bundle b;
  b.index = 3999;
  b.tick = 72000;
  sync::AvatarUpdate a;
  a.position = {any(rng, 1, 9), any(rng, 1, 5)};
  a.velocity = {any(rng, -6, 6), any(rng, -6, 6)};
  a.control = {any(rng, 1, 9), any(rng, 1, 5)};
  if (precision == Precision::kRounded)
    a = {a.cause, rounded_place(a.position), rounded_motion(a.velocity), a.awake, a.model, rounded_place(a.control)};
  b.avatar = a;
  for (int i = 0; i < bodies; ++i) {
    sync::BodyUpdate u;
    u.body = static_cast<EntityId>((2 * i + 1) * static_cast<int>(scene.bodies.size()) / (2 * bodies));
    u.has_state = true;
    u.held = true;
    u.epoch = 1 + rng.below(20);
    u.claimed = 71990;
    u.state = {
        {any(rng, 1, 9), any(rng, 1, 5)}, any(rng, -3, 3), {any(rng, -4, 4), any(rng, -4, 4)}, any(rng, -9, 9), true};
    if (precision == Precision::kRounded) u.state = rounded(u.state);
    b.bodies.push_back(u);
  }
  p.updates.push_back(b);
  return p;
}

/// Does the work in batches, and counts.
void run(benchmark::State& state, const auto& work) {
  double seconds = 0;
  std::uint64_t allocated = 0;
  for (auto unused : state) {
    (void)unused;
    const std::uint64_t before = allocations();
    seconds += seconds_of([&work] {
      for (int i = 0; i < kBatch; ++i) work();
    });
    allocated += allocations() - before;
  }
  const double n = static_cast<double>(state.iterations()) * kBatch;
  state.counters["ns"] = seconds * 1e9 / n;
  state.counters["allocs"] = static_cast<double>(allocated) / n;
}

void encode_as(benchmark::State& state, Precision precision) {
  const auto bodies = static_cast<int>(state.range(0));
  const sync::StatePacket p = packet(room(60, 4), bodies, precision);
  wire::StateEncoder encoder;
  encoder.encode(p);
  run(state, [&] { benchmark::DoNotOptimize(encoder.encode(p)); });
  if (bodies == 0) return;
  sync::StatePacket less = p;
  less.updates[0].bodies.clear();
  const double bytes = static_cast<double>(wire::encode(p).size() - wire::encode(less).size()) / bodies;
  state.counters["bytes"] = bytes;
  state.counters["of_raw"] = bytes / kRawBytes;
  state.counters["of_dis"] = bytes / kDisBytes;
}

void encode(benchmark::State& state) {
  encode_as(state, Precision::kRounded);
}
void encode_exact(benchmark::State& state) {
  encode_as(state, Precision::kExact);
}

void decode(benchmark::State& state) {
  const wire::Bytes bytes = wire::encode(packet(room(60, 4), static_cast<int>(state.range(0))));
  wire::StateDecoder decoder;
  decoder.decode(bytes, 1);
  run(state, [&] { benchmark::DoNotOptimize(decoder.decode(bytes, 1)); });
}

void admit(benchmark::State& state) {
  const Scene scene = room(60, 4);
  const sync::StatePacket p = packet(scene, static_cast<int>(state.range(0)));
  if (sync::admit(p, scene, 4, p.mark_tick) != sync::DropReason::kNone) return state.SkipWithError("not admitted");
  run(state, [&] { benchmark::DoNotOptimize(sync::admit(p, scene, 4, p.mark_tick)); });
}

/// 100 ms and every impairment there is, one in flight a tick.
void shim(benchmark::State& state) {
  link::Shim s(shell::parse_netem("delay 100ms 20ms 25% loss 2% duplicate 1% corrupt 0.1% reorder 5% rate 10mbit"), 1);
  const std::vector<std::byte> datagram(static_cast<std::size_t>(state.range(0)), std::byte{1});
  Micros now = 0;
  run(state, [&] {
    now += kMicrosPerSecond / kTicksPerSecond;
    s.accept(now, datagram);
    while (auto d = s.release(now)) benchmark::DoNotOptimize(d);
  });
}

BENCHMARK(encode)->ArgName("bodies")->Arg(0)->Arg(1)->Arg(4)->Arg(16);
BENCHMARK(encode_exact)->ArgName("bodies")->Arg(1)->Arg(4)->Arg(16);
BENCHMARK(decode)->ArgName("bodies")->Arg(0)->Arg(1)->Arg(4)->Arg(16);
BENCHMARK(admit)->ArgName("bodies")->Arg(1)->Arg(16);
BENCHMARK(shim)->ArgName("bytes")->Arg(100);

}  // namespace
}  // namespace padr::bench
