// What a frame costs: everything a replica does in a tick, from the datagrams that have come in to those that go out,
// beside one step of a bare Box2D world in the same state, measured after every frame. Network: 100 ms, 2 % lost;
// `outages`: links that lose everything for 33 datagrams after every 100, on average; `quiet`: perfect.
//
//   steps       a frame's mean over that of a step
//   frame_us    mean; p99_us: 99 of 100 are shorter; most_us
//   share_p99   p99 of the 16.7 ms that a frame has
//   replays     steps of the whole world made again for updates that came late, a frame
//   allocs      allocations a frame
//   behind      share of the frames that left something to be replayed later
#include <benchmark/benchmark.h>

#include <algorithm>

#include "common/scenarios/scenarios.h"
#include "tests/bench/bare_world.h"
#include "tests/bench/party.h"

namespace padr::bench {
namespace {

// Longer than any history that is kept, and until records, such as the most contacts ever, have become rare.
constexpr int kWarmUp = 60 * kTicksPerSecond;
constexpr int kFrames = 10 * kTicksPerSecond;
// With other inputs and networks each: how much happens differs, but not where everything moves all the time, or
// nothing.
constexpr std::uint64_t kRuns = 5;

struct Measured {
  std::vector<double> frames;  // s
  double bare = 0;             // s, sum
  std::uint64_t allocations = 0;
  std::uint64_t replayed = 0;
  std::uint64_t whole = 0;
  std::uint64_t behind = 0;
};

void measure(Measured& m, const Scene& scene, int peers, const std::string& input, const std::string& netem,
             std::uint64_t seed) {
  Party party(scene, peers, netem, input, seed);
  BareWorld bare(scene, peers);
  for (int i = 0; i < kWarmUp; ++i) party.tick();
  const std::uint64_t replayed = party.first().agreed().replayed_steps();
  const std::uint64_t whole = whole_replays(party.first().agreed());
  for (int i = 0; i < kFrames; ++i) {
    const Party::Frame f = party.tick();
    m.frames.push_back(f.seconds);
    m.allocations += f.allocations;
    m.behind += party.first().agreed().replaying() ? 1U : 0U;
    bare.put(party.first().live().world().kinematics(), party.first().agreed().predicted_state().holds);
    m.bare += seconds_of([&bare] { bare.step(); });
  }
  m.replayed += party.first().agreed().replayed_steps() - replayed;
  m.whole += whole_replays(party.first().agreed()) - whole;
}

void report(benchmark::State& state, Measured m) {
  const auto n = static_cast<double>(m.frames.size());
  double sum = 0;
  for (const double f : m.frames) sum += f;
  std::sort(m.frames.begin(), m.frames.end());
  const double p99 = m.frames[m.frames.size() * 99 / 100];
  state.counters["steps"] = sum / m.bare;
  state.counters["frame_us"] = sum / n * 1e6;
  state.counters["bare_us"] = m.bare / n * 1e6;
  state.counters["p99_us"] = p99 * 1e6;
  state.counters["most_us"] = m.frames.back() * 1e6;
  state.counters["share_p99"] = p99 * kTicksPerSecond;
  state.counters["replays"] = static_cast<double>(m.replayed) / n;
  state.counters["whole"] = static_cast<double>(m.whole) / n;
  state.counters["behind"] = static_cast<double>(m.behind) / n;
  state.counters["allocs"] = static_cast<double>(m.allocations) / n;
}

/// `scene`: of so many bodies and places to start from; `input`: what avatars do.
void frame(benchmark::State& state, Scene (*scene)(int, int), const char* input,
           const char* netem = "delay 100ms loss 2%", std::uint64_t runs = 1) {
  const auto bodies = static_cast<int>(state.range(0));
  const auto peers = static_cast<int>(state.range(1));
  const Scene made = scene(bodies, peers);
  for (auto unused : state) {
    (void)unused;
    Measured m;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) measure(m, made, peers, input, netem, seed);
    report(state, std::move(m));
  }
}

void by_bodies(benchmark::internal::Benchmark* b) {
  for (const int bodies : {20, 60, 200, 1000, 5000}) b->Args({bodies, 4});
}
void by_peers(benchmark::internal::Benchmark* b) {
  for (const int peers : {2, 8, 22}) b->Args({60, peers});
}
/// What peers.py has its peers play.
Scene arena(int, int) {
  return scenarios::load_embedded("arena", 1);
}

void by_real_peers(benchmark::internal::Benchmark* b) {
  for (const int peers : {4, 8, 16, 32, 64}) b->Args({60, peers});
}
void once(benchmark::internal::Benchmark* b) {
  b->Iterations(1)->Unit(benchmark::kMillisecond)->ArgNames({"bodies", "peers"});
}

// Avatars wander, and what they do not touch rests; nobody moves, and everything sleeps; avatars wander, and everything
// moves all the time; nobody moves and nothing is lost, as many as peers.py has real peers of.
BENCHMARK_CAPTURE(frame, wander, room, "wander", "delay 100ms loss 2%", kRuns)
    ->Apply(once)
    ->Apply(by_bodies)
    ->Apply(by_peers);
BENCHMARK_CAPTURE(frame, asleep, room, "rest")->Apply(once)->Apply(by_bodies)->Apply(by_peers);
BENCHMARK_CAPTURE(frame, awake, restless_room, "wander")->Apply(once)->Args({60, 4})->Args({200, 4})->Args({1000, 4});
BENCHMARK_CAPTURE(frame, outages, restless_room, "wander", "delay 100ms loss gemodel 1% 3%")
    ->Apply(once)
    ->Args({60, 4})
    ->Args({1000, 4});
BENCHMARK_CAPTURE(frame, quiet, arena, "rest", "")->Apply(once)->Apply(by_real_peers);

}  // namespace
}  // namespace padr::bench
