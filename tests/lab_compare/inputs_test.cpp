#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "common/model/rng.h"
#include "common/scenarios/scenarios.h"
#include "shell/netem_text.h"
#include "shell/scenario_flags.h"
#include "tests/lab_compare/ending.h"
#include "tests/seed.h"
#include "tools/lab/alternatives/alternative_run.h"
#include "tools/lab/alternatives/input_sync.h"

namespace padr::lab::alternatives {
namespace {

Spec rollback(Tick input_delay, Tick prediction = kGgpoPrediction) {
  return {.kind = Kind::kInputs, .hz = 60, .input_delay = input_delay, .prediction = prediction};
}

Spec lockstep(Tick input_delay) {
  return rollback(input_delay, 0);
}

TEST(InputTrack, WhatWasWrittenIsRead) {
  const Scene scene = scenarios::load_embedded("arena", 1);
  const Quantiser z(scene);
  const std::uint64_t seed = test::seed(1);
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    InputTrack track(input_of({3, 4}, z), 0);
    Vec2 hand{10, 7};
    for (int i = 0; i < 100; ++i) {
      // Rests, moves, and now and then jumps to anywhere, beyond the play area too.
      if (rng.chance(0.5)) hand = hand + Vec2{static_cast<float>(rng.uniform(-0.1, 0.1)), 0.05F};
      if (rng.chance(0.02)) hand = {static_cast<float>(rng.uniform(-1e4, 1e4)), static_cast<float>(rng.uniform(0, 15))};
      track.add(input_of(hand, z));
    }
    const auto from = static_cast<Tick>(1 + rng.below(100));
    BitWriter w;
    const std::size_t room = rng.chance(0.5) ? 100'000 : 600;
    const Tick most = rng.chance(0.5) ? 64 : 200;
    const std::uint64_t told = track.write(w, from, most, room, z);
    EXPECT_LE(w.bits(), room);
    EXPECT_LE(told, static_cast<std::uint64_t>(most));
    if (room > 600) {
      EXPECT_EQ(told, static_cast<std::uint64_t>(std::min(most, 100 - from + 1)));
    }
    BitReader r(w.bytes());
    InputReader inputs(r, z);
    ASSERT_EQ(inputs.left(), told);
    for (Tick t = from; inputs.left() > 0; ++t) ASSERT_EQ(inputs.next(), track.at(t)) << "tick " << t;
    EXPECT_TRUE(r.ok());
  }
}

TEST(InputTrack, BeyondTheNewestTheLastIsRepeated) {
  const Quantiser z(scenarios::load_embedded("arena", 1));
  InputTrack track(input_of({1, 1}, z), 2);
  EXPECT_EQ(track.newest(), 2);
  track.add(input_of({2, 2}, z));
  EXPECT_EQ(track.at(0), input_of({1, 1}, z));
  EXPECT_EQ(track.at(2), input_of({1, 1}, z));
  EXPECT_EQ(track.at(3), input_of({2, 2}, z));
  EXPECT_EQ(track.at(30), input_of({2, 2}, z));
  track.forget_before(3);
  EXPECT_EQ(track.newest(), 3);
  EXPECT_EQ(track.at(3), input_of({2, 2}, z));
}

/// A hand that rests where its avatar is and goes to another place at a tick.
class Jump final : public scenarios::InputSource {
 public:
  Jump(Vec2 rest, Vec2 then, Tick when) : rest_(rest), then_(then), when_(when) {}
  Vec2 target(Tick tick) override { return tick < when_ ? rest_ : then_; }

 private:
  Vec2 rest_, then_;
  Tick when_;
};

constexpr Tick kPlay = 10 * kTicksPerSecond;

struct Session {
  Session(const Spec& spec, const std::string& netem, std::uint64_t seed, int peers = 3) {
    SessionConfig config;
    config.scene = scenarios::load_embedded("arena", seed);
    config.peers = peers;
    config.spec = spec;
    config.netem = shell::parse_netem(netem, nullptr);
    config.netem_seed = seed;
    for (PeerId p = 0; p < peers; ++p) {
      inputs.push_back(std::make_unique<Ending>(shell::load_input("wander", config.scene, p, seed), kPlay));
      config.inputs.push_back(inputs.back().get());
    }
    run = std::make_unique<AlternativeRun>(std::move(config));
  }
  const InputSync& peer(PeerId p) const { return dynamic_cast<const InputSync&>(run->peer(p)); }
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::unique_ptr<AlternativeRun> run;
};

const char* const kBad = "delay 80ms 40ms loss 20% duplicate 5% reorder 10% corrupt 1%";

TEST(Rollback, ConvergesToIdenticalWorldsInSpiteOfLoss) {
  const std::uint64_t seed = test::seed(3);
  SCOPED_TRACE(seed);
  for (const Tick delay : {0, 3}) {
    const Session s(rollback(delay), kBad, seed);
    while (s.run->now() < kPlay) s.run->step();
    EXPECT_GT(s.run->meter().overall().peak_m, 0.02) << "the test is to guess wrong now and then";
    for (PeerId p = 0; p < 3; ++p) {
      EXPECT_GT(s.peer(p).simulated_again(), 100U);
      EXPECT_GT(s.peer(p).settled().tick, kPlay - 60) << "it goes on settling";
    }
    for (int i = 0; i < kTicksPerSecond; ++i) s.run->step();
    EXPECT_EQ(s.run->mismatches(), 0U);
    for (PeerId p = 0; p < 3; ++p)
      for (EntityId e = 0; e < s.peer(p).world().entities(); ++e)
        EXPECT_EQ(s.peer(p).world().state(e), s.peer(0).world().state(e)) << "peer " << int{p} << ", entity " << e;
    EXPECT_EQ(s.run->meter().overall().final_m, 0);
  }
}

TEST(Lockstep, NeverDiverges) {
  const std::uint64_t seed = test::seed(4);
  SCOPED_TRACE(seed);
  for (const Tick delay : {2, 12}) {
    const Session s(lockstep(delay), kBad, seed);
    while (s.run->now() < kPlay) {
      s.run->step();
      for (PeerId p = 0; p < 3; ++p) ASSERT_EQ(s.peer(p).settled().tick, s.peer(p).tick()) << "nothing is guessed";
    }
    EXPECT_EQ(s.run->mismatches(), 0U);
    for (PeerId p = 0; p < 3; ++p) {
      EXPECT_EQ(s.peer(p).simulated_again(), 0U);
      EXPECT_GT(s.peer(p).tick(), kPlay - 90);
    }
    if (delay == 2) {
      EXPECT_GT(s.run->waiting().frozen_share, 0) << "such a link makes it wait";
    }
  }
}

TEST(Lockstep, WithEnoughInputDelayNothingIsLateOrWrong) {
  const Session s(lockstep(7), "delay 100ms", 5);
  while (s.run->now() < kPlay) s.run->step();
  EXPECT_EQ(s.run->meter().overall().peak_m, 0);
  const Waiting w = s.run->waiting();
  EXPECT_EQ(w.frozen_share, 0);
  EXPECT_NEAR(w.hand_delay_s, 7.0 / kTicksPerSecond, 1e-9);
  EXPECT_GT(s.run->hands_mean_m(), 0.1) << "what the hands have decided is not to be seen before";
}

/// Two peers whose datagrams the test carries by hand.
struct Pair {
  explicit Pair(const Spec& spec) : scene(scenarios::load_embedded("arena", 1)) {
    for (PeerId p = 0; p < 2; ++p) {
      peers.push_back(std::make_unique<InputSync>(scene, AlternativeConfig{p, 2, 1, spec}));
      hands.push_back(peers[p]->world().position(peers[p]->world().avatar(p)));
    }
  }
  void step() {
    for (PeerId p = 0; p < 2; ++p) {
      peers[p]->step(hands[p]);
      sent.push_back(peers[p]->outgoing());
    }
  }
  /// All that one of them has sent since the last time.
  void carry() {
    for (const auto& datagrams : sent)
      for (const node::Outgoing& o : datagrams) peers[o.to]->receive(o.bytes);
    sent.clear();
  }
  Vec2 seen(PeerId by, PeerId of) const { return peers[by]->world().position(peers[by]->world().avatar(of)); }
  Scene scene;
  std::vector<std::unique_ptr<InputSync>> peers;
  std::vector<Vec2> hands;
  std::vector<std::vector<node::Outgoing>> sent;
};

TEST(Rollback, TheRepeatedInputIsCorrected) {
  Pair pair(rollback(0));
  for (int i = 0; i < 20; ++i) {
    pair.step();
    pair.carry();
  }
  const Vec2 before = pair.seen(0, 1);
  pair.hands[1] = before + Vec2{0, 2};
  for (int i = 0; i < 6; ++i) pair.step();
  EXPECT_EQ(pair.seen(0, 1), before) << "not heard of it: it is taken to stay";
  EXPECT_GT(distance(pair.seen(1, 1), before), 0.05F) << "its own avatar follows at once";
  EXPECT_EQ(pair.peers[0]->simulated_again(), 0U);
  pair.carry();
  pair.step();
  EXPECT_EQ(pair.peers[0]->simulated_again(), 6U);
  EXPECT_EQ(pair.seen(0, 1), pair.seen(1, 1)) << "as if it had known from the beginning";
  EXPECT_EQ(pair.peers[1]->simulated_again(), 0U) << "nothing that it had guessed was wrong";
}

TEST(Rollback, StopsAtThePredictionLimitAndCatchesUp) {
  Pair pair(rollback(2));
  const auto ticks_of = [&pair] { return pair.peers[0]->tick(); };
  for (int i = 0; i < 2 + kGgpoPrediction; ++i) pair.step();
  EXPECT_EQ(ticks_of(), 2 + kGgpoPrediction) << "inputs of the first two ticks are known to all";
  EXPECT_FALSE(pair.peers[0]->frozen());
  EXPECT_EQ(pair.peers[0]->hand_delay(), 2);
  for (int i = 1; i <= 30; ++i) {
    pair.step();
    EXPECT_EQ(ticks_of(), 2 + kGgpoPrediction);
    EXPECT_TRUE(pair.peers[0]->frozen());
    EXPECT_EQ(pair.peers[0]->hand_delay(), 2 + i);
  }
  pair.carry();
  pair.step();
  EXPECT_EQ(ticks_of(), 41);
  EXPECT_FALSE(pair.peers[0]->frozen());
  EXPECT_EQ(pair.peers[0]->hand_delay(), 2);
}

TEST(Lockstep, WaitsForOneInput) {
  Pair pair(lockstep(1));
  pair.step();
  EXPECT_EQ(pair.peers[0]->tick(), 1);
  pair.step();
  EXPECT_EQ(pair.peers[0]->tick(), 1);
  EXPECT_TRUE(pair.peers[0]->frozen());
  pair.carry();
  pair.step();
  EXPECT_EQ(pair.peers[0]->tick(), 3);
}

/// Black box: when does the avatar in the view of its own peer leave the place that it would have kept?
TEST(HandDelay, IsWhatAHandMeets) {
  for (const Spec& spec : {rollback(0), rollback(4), lockstep(2), lockstep(12), Spec{.kind = Kind::kStateSync}}) {
    constexpr Tick kWhen = 60;
    SessionConfig config;
    config.scene = scenarios::load_embedded("arena", 1);
    config.spec = spec;
    config.netem = shell::parse_netem("delay 100ms", nullptr);
    std::vector<std::unique_ptr<Jump>> hands;
    for (PeerId p = 0; p < 2; ++p) {
      const Vec2 rest = config.scene.avatar.spawns[p];
      hands.push_back(std::make_unique<Jump>(rest, p == 0 ? rest + Vec2{0.5F, 0.5F} : rest, kWhen));
      config.inputs.push_back(hands.back().get());
    }
    AlternativeRun run(std::move(config));
    const auto own = [&run] { return run.peer(0).world().position(run.peer(0).world().avatar(0)); };
    while (run.now() < kWhen - 1) run.step();
    const Vec2 rest = own();
    while (own() == rest && run.now() < kWhen + 60) run.step();
    EXPECT_EQ(run.now() - kWhen, run.peer(0).hand_delay()) << "delay " << spec.input_delay;
  }
}

}  // namespace
}  // namespace padr::lab::alternatives
