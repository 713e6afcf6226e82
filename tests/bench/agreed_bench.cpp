// What keeping the agreed world costs besides stepping it: an update that comes late, hashing, saving and restoring,
// copying and looking ahead; and the lab beside its own worlds stepped as often and nothing else. All in multiples of a
// step of the same world.
#include <benchmark/benchmark.h>

#include <utility>

#include "common/reckoning/live_world.h"
#include "common/reckoning/prediction.h"
#include "common/scenarios/scenarios.h"
#include "common/sync/agreed_world.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "tests/bench/bare_world.h"
#include "tests/bench/party.h"
#include "tools/lab/simulation.h"

namespace padr::bench {
namespace {

/// An avatar update of peer 1 that is `depth` ticks late, time after time.
///   steps           of catching up, in steps of the world at that time
///   steps_per_tick  that over the depth
void late_update(benchmark::State& state) {
  const auto depth = static_cast<Tick>(state.range(0));
  const auto bodies = static_cast<int>(state.range(1));
  const Scene scene = restless_room(bodies, 2);
  sync::AgreedWorld agreed(scene, {2, 2, 0, true, true, {}}, {});
  world::World bare(scene, 2);
  world::Snapshot s;
  for (Tick t = 0; t < 2 * kTicksPerSecond; ++t) agreed.step();
  double late = 0;
  double step = 0;
  std::uint32_t index = 0;
  for (auto unused : state) {
    (void)unused;
    for (Tick t = 0; t < depth; ++t) agreed.step();
    agreed.predicted().world().save(s);
    bare.restore(s);
    step += seconds_of([&bare] { bare.step(); });
    sync::Bundle b;
    b.peer = 1;
    b.index = index++;
    b.tick = agreed.now() - depth + 1;
    b.avatar.emplace();
    b.avatar->position = agreed.predicted().world().position(agreed.predicted().world().avatar(1));
    late += seconds_of([&] {
      agreed.insert(b);
      agreed.catch_up();
    });
  }
  state.counters["steps"] = late / step;
  state.counters["steps_per_tick"] = late / step / static_cast<double>(depth);
}

/// Of the whole state: what every confirmed tick, every predicted tick and every rewinding costs. `fold_steps`: a tick
/// of the agreed world, avatars' models and all, in bare Box2D steps; the others in such ticks.
void state_of(benchmark::State& state) {
  const Scene scene = restless_room(static_cast<int>(state.range(0)), 4);
  sync::Fold fold(scene, 4, 4, true);
  for (int i = 0; i < kTicksPerSecond; ++i) fold.step();
  sync::FoldState s;
  BareWorld bare(scene, 4, kNoPeer);
  double hash = 0;
  double save = 0;
  double restore = 0;
  double step = 0;
  double bare_step = 0;
  for (auto unused : state) {
    (void)unused;
    fold.save(s);
    bare.put(s.world.entities, s.holds);
    bare_step += seconds_of([&bare] { bare.step(); });
    step += seconds_of([&fold] { fold.step(); });
    save += seconds_of([&] { fold.save(s); });
    hash += seconds_of([&s] { benchmark::DoNotOptimize(hash_of(s)); });
    restore += seconds_of([&] { fold.restore(s); });
  }
  state.counters["fold_steps"] = step / bare_step;
  state.counters["save_steps"] = save / step;
  state.counters["hash_steps"] = hash / step;
  state.counters["restore_steps"] = restore / step;
}

/// What a peer copies, in a room where every body moves, in ticks of the agreed world:
///   adopt_steps  taking over the predicted world, all of which has moved, in the live one
///   same_steps   the same, when nothing has
///   ahead_steps  a look-ahead, which copies what is around the avatar and steps that
///   ahead_count  steps of that copy in each
void copies(benchmark::State& state) {
  const Scene scene = restless_room(static_cast<int>(state.range(0)), 2);
  sync::Fold fold(scene, 2, 2, true);
  for (int i = 0; i < kTicksPerSecond; ++i) fold.step();
  sync::FoldState s;
  fold.save(s);
  sync::LiveWorld live(scene, s, 0, true);
  sync::InteractionPredictor predictor(scene, 2, 0, Technique{});
  std::vector<bool> own(static_cast<std::size_t>(live.world().entities()), false);
  own[live.avatar()] = true;
  const Vec2 target = live.world().position(live.avatar()) + Vec2{3, 0};
  double step = 0;
  double adopt = 0;
  double same = 0;
  double ahead = 0;
  for (auto unused : state) {
    (void)unused;
    step += seconds_of([&fold] { fold.step(); });
    fold.save(s);
    adopt += seconds_of([&] { live.adopt(s, own, false); });
    same += seconds_of([&] { live.adopt(s, own, false); });
    ahead += seconds_of([&] { benchmark::DoNotOptimize(predictor.predict(live.world(), target, s)); });
  }
  state.counters["adopt_steps"] = adopt / step;
  state.counters["same_steps"] = same / step;
  state.counters["ahead_steps"] = ahead / step;
  state.counters["ahead_count"] = static_cast<double>(predictor.steps()) / static_cast<double>(state.iterations());
}

/// A lab run of 4 peers in the arena, 100 ms, 2 % lost, and beside it the same worlds stepped as often: of every peer a
/// live and a predicted one, in turn, the predicted one once more for every step that was replayed as a whole.
///   runs_per_s   of one minute each
///   speed        of bare physics, which is 1
void lab_run(benchmark::State& state) {
  constexpr Tick kTicks = 60 * kTicksPerSecond;
  constexpr PeerId kPeers = 4;
  double run = 0;
  double bare = 0;
  for (auto unused : state) {
    (void)unused;
    lab::SimulationConfig c;
    c.scene = scenarios::load_embedded("arena", 1);
    c.peers = kPeers;
    c.netem = shell::parse_netem("delay 100ms loss 2%");
    c.ticks = kTicks;
    std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
    for (PeerId p = 0; p < kPeers; ++p) {
      inputs.push_back(shell::make_input("wander", {c.scene, p, 1, {}}));
      c.inputs.push_back(inputs.back().get());
    }
    struct Bare {
      std::unique_ptr<BareWorld> live;
      std::unique_ptr<BareWorld> predicted;
      std::uint64_t replayed = 0;
      std::uint64_t steps = 0;
    };
    std::vector<Bare> worlds;
    for (PeerId p = 0; p < kPeers; ++p)
      worlds.push_back(
          {std::make_unique<BareWorld>(c.scene, kPeers, p), std::make_unique<BareWorld>(c.scene, kPeers, kNoPeer)});
    lab::Simulation simulation(std::move(c));
    for (Tick t = 0; t < kTicks; ++t) {
      run += seconds_of([&simulation] { simulation.step(); });
      for (PeerId p = 0; p < kPeers; ++p) {
        const node::Replica& replica = simulation.replica(p);
        Bare& w = worlds[p];
        w.live->put(replica.live().world().kinematics(), replica.agreed().predicted_state().holds);
        w.predicted->put(replica.agreed().predicted_state().world.entities, replica.agreed().predicted_state().holds);
        w.steps = 1 + whole_replays(replica.agreed()) - std::exchange(w.replayed, whole_replays(replica.agreed()));
      }
      bare += seconds_of([&worlds] {
        for (const Bare& w : worlds) {
          for (std::uint64_t i = 0; i < w.steps; ++i) w.predicted->step();
          w.live->step();
        }
      });
    }
  }
  state.counters["runs_per_s"] = static_cast<double>(state.iterations()) / run;
  state.counters["speed"] = bare / run;
}

BENCHMARK(late_update)
    ->ArgNames({"depth", "bodies"})
    ->Args({6, 60})
    ->Args({6, 1000})
    ->Args({30, 60})
    ->Args({120, 60})
    ->Iterations(50)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(state_of)->ArgName("bodies")->Arg(60)->Arg(200)->Arg(1000)->Iterations(200);
BENCHMARK(copies)->ArgName("bodies")->Arg(60)->Arg(200)->Arg(1000)->Iterations(200);
BENCHMARK(lab_run)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace padr::bench
