#include "common/trace/fidelity.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <utility>

#include "common/scenarios/scenarios.h"
#include "common/trace/physics_consistency_cost.h"
#include "common/trace/undisturbed.h"
#include "common/world/avatar_control.h"
#include "shell/input_text.h"
#include "tests/world/test_scene.h"
#include "tools/lab/simulation.h"

namespace padr {
namespace {

using trace::Doers;

/// Two avatars, at (2, 4) and (2, 7), and two balls at rest at (5, 4) and (8, 4): what a hand can follow.
struct Stage {
  Stage() {
    scene.avatar.spawns = {{2, 4}, {2, 7}};
    scene.bodies.push_back(scene.bodies.front());
    scene.bodies.back().position = {8, 4};
    const world::World world(scene, 2);
    for (EntityId e = 0; e < world.entities(); ++e) rest.push_back(world.state(e));
    for (BodyState& s : rest) s.awake = false;
    views = {rest, rest};
    targets = {scene.avatar.spawns[0], scene.avatar.spawns[1]};
    meter = std::make_unique<trace::FidelityMeter>(scene, 2, std::vector<PeerId>{0, 1});
  }
  void tick() {
    const std::vector<trace::PlayerView> now{{true, views[0], targets[0]}, {true, views[1], targets[1]}};
    meter->tick(at++, now);
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  const trace::FidelityPoint& point(std::size_t viewer) const { return meter->series(viewer).back(); }
  const trace::PccPoint& pcc(std::size_t viewer) const { return meter->pcc().series(viewer).back(); }

  Scene scene = test::corridor();
  std::vector<BodyState> rest;
  std::vector<std::vector<BodyState>> views;
  std::vector<Vec2> targets;
  std::unique_ptr<trace::FidelityMeter> meter;
  Tick at = 0;
};

TEST(Fidelity, TwoViewsMayAgreeOnWhatNeverHappened) {
  Stage s;
  s.ticks(10);
  EXPECT_EQ(s.point(0).error_m(), 0);
  // In both views the first ball is suddenly a metre away, though no avatar has touched it: no inconsistency at all.
  for (auto& view : s.views) view[0].position.x += 1;
  s.tick();
  for (const std::size_t viewer : {0U, 1U}) {
    EXPECT_FLOAT_EQ(s.point(viewer).nobody_m, 1);
    EXPECT_EQ(s.point(viewer).own_m + s.point(viewer).others_m, 0);
    EXPECT_EQ(s.pcc(viewer).cost_m, 0) << "views do not part";
  }
  // The copies are taken anew after the horizon, counted from tick 0: what is there then is what there is.
  s.ticks(50);
  EXPECT_EQ(s.at, 61);
  EXPECT_FLOAT_EQ(s.point(0).nobody_m, 1);
  s.tick();
  EXPECT_EQ(s.point(0).error_m(), 0);
}

/// The first player really pushes the first ball; both views show it, as they should.
struct Push : Stage {
  Push() : world(scene, 2) {
    world.set_present(world.avatar(0), true);
    world.set_free(0, true);
    tick();
    targets[0] = {7, 4};
  }
  void play(int n) {
    for (int i = 0; i < n; ++i) {
      world::drive_avatar(world, 0, targets[0]);
      world.step();
      for (auto& view : views) {
        for (const EntityId e : {EntityId{0}, EntityId{1}, world.avatar(0)}) view[e] = world.state(e);
        if (adopt) adopt(view, &view == &views[0]);
      }
      tick();
    }
  }
  world::World world;
  std::function<void(std::vector<BodyState>&, bool first)> adopt;
};

TEST(Fidelity, WhatAPlayerDidInEverybodysViewIsPerfect) {
  Push s;
  s.play(150);
  EXPECT_GT(s.views[0][0].position.x, 7) << "the ball has been pushed";
  EXPECT_GE(s.meter->deeds(0), 1U);
  EXPECT_EQ(s.meter->deeds(1), 0U);
  EXPECT_EQ(s.meter->overall().peak_m, 0);
  EXPECT_EQ(s.meter->left_out(), 0);
}

TEST(Fidelity, AViewThatShowsADeedElsewhereIsOffAndTheDoersIsNot) {
  Push s;
  s.adopt = [](auto& view, bool first) {
    if (!first) view[0] = {{5, 4}, 0, {}, 0, false};  // the second player has not heard of it
  };
  s.play(150);
  const float off = distance(s.views[0][0].position, s.views[1][0].position);
  EXPECT_GT(off, 2);
  EXPECT_FLOAT_EQ(s.point(1).others_m, off);
  EXPECT_EQ(s.meter->result(0).peak_m, 0);
  EXPECT_FLOAT_EQ(s.pcc(0).cost_m, off) << "and that is the cost of the first avatar";
  EXPECT_EQ(s.pcc(0).bodies, 1);
  EXPECT_EQ(s.meter->pcc().result(1).peak_m, 0);
}

TEST(Fidelity, APlayerWhoTakesOverAnotherWorldsWordForItsOwnDeedIsOff) {
  Push s;
  // Everybody agrees that the ball did not move.
  s.adopt = [](auto& view, bool) { view[0] = {{5, 4}, 0, {}, 0, false}; };
  s.play(150);
  EXPECT_GT(s.meter->result(0).own_mean_m, 0.1);
  EXPECT_GT(s.meter->result(1).others_mean_m, 0.1);
  EXPECT_EQ(s.meter->pcc().result(0).peak_m, 0) << "no inconsistency";
}

TEST(Fidelity, AModelThatTouchesWhatItsAvatarNeverTouchedIsItsAvatarsCost) {
  Stage s;
  s.ticks(5);
  // The paper's ball: in the second player's view the first avatar's model runs on to the ball, which rolls away.
  s.views[1][2].position = {4.1F, 4};
  s.views[1][0].position = {5.125F, 4};
  s.tick();
  EXPECT_FLOAT_EQ(s.pcc(0).cost_m, 0.125F);
  EXPECT_EQ(s.pcc(0).bodies, 1);
  s.views[1][0].position = {7.1F, 4};
  s.views[1][1].position = {8.1F, 4};  // it has reached the other ball
  s.tick();
  EXPECT_FLOAT_EQ(s.pcc(0).cost_m, 2.2F);
  EXPECT_EQ(s.pcc(0).bodies, 2);
  EXPECT_EQ(s.pcc(1).cost_m, 0);
  EXPECT_FLOAT_EQ(s.point(1).nobody_m, 2.2F) << "nobody did it";
  EXPECT_EQ(s.point(0).error_m(), 0);
}

// Once, a body that two players touch was on account of whoever had disturbed it the last time.
TEST(Fidelity, ADisturberIsForgottenOnceTheViewsAgree) {
  Scene scene = test::corridor();
  scene.avatar.spawns = {{1, 1}, {2, 1}, {3, 1}};
  const auto bodies = static_cast<EntityId>(scene.bodies.size());
  trace::PccMeter meter(scene, 3, {0, 1, 2});
  Doers doers(bodies, 4);
  const auto costs = [&](Tick t, std::array<float, 3> x) {
    std::array<std::vector<BodyState>, 3> live;
    std::vector<trace::PlayerView> views;
    for (std::size_t v = 0; v < 3; ++v) {
      live[v].resize(bodies + 3U);
      live[v][0].position = {x[v], 10};
      for (std::size_t p = 0; p < 3; ++p) live[v][bodies + p].position = scene.avatar.spawns[p];
      views.push_back({true, live[v], {}});
    }
    doers.judge(t);
    meter.tick(t, views, doers);
    return std::array{meter.series(0).back().cost_m, meter.series(1).back().cost_m, meter.series(2).back().cost_m};
  };
  doers.touched(0, 2, 1);
  EXPECT_GT(costs(1, {10, 10, 10.5F})[2], 0);
  EXPECT_EQ(costs(2, {10, 10, 10}), (std::array{0.0F, 0.0F, 0.0F}));
  for (Tick t = 600; t < 603; ++t) {
    doers.touched(0, 0, t);
    doers.touched(0, 1, t);
    EXPECT_EQ(costs(t, {10.4F, 10, 10})[2], 0);
  }
}

TEST(Fidelity, WhatSomebodyPushesFromOutsideIsLeftOut) {
  Stage s;
  s.ticks(3);
  s.meter->pushed(0, s.at);
  for (auto& view : s.views) view[0].position.x += 1;
  s.tick();
  EXPECT_EQ(s.point(0).error_m(), 0);
  EXPECT_EQ(s.meter->left_out(), 1);
}

TEST(Doers, AsATable) {
  Doers d(3, 2);
  const auto of = [&d](EntityId b, Tick now) {
    d.judge(now);
    return d.of(b);
  };
  EXPECT_EQ(of(0, 0), Doers::kNobody);
  d.touched(0, 1, 100);
  EXPECT_EQ(of(0, 100), 1);
  EXPECT_EQ(of(0, 100 + Doers::kAfter - 1), 1);
  EXPECT_EQ(of(0, 100 + Doers::kAfter), Doers::kNobody);
  // Two within a second.
  d.touched(0, 0, 100 + Doers::kTogether - 1);
  EXPECT_EQ(of(0, 100 + Doers::kTogether - 1), Doers::kSeveral);
  EXPECT_EQ(of(0, 100 + Doers::kTogether), 0);
  // Through contacts, either way round and over more than one; an avatar is no body.
  d.spread({{0, 1}, {0, 4}, {1, 2}}, 160);
  EXPECT_EQ(of(2, 160), 0);
  // The time goes with it.
  EXPECT_EQ(of(2, 159 + Doers::kAfter), Doers::kNobody);
  // Too long ago to go on.
  Doers late(2, 1);
  late.touched(0, 0, 0);
  late.spread({{0, 1}}, Doers::kTogether);
  late.judge(Doers::kTogether);
  EXPECT_EQ(late.of(1), Doers::kNobody);
}

/// One peer that owns everything, so that nothing but what its player does happens in its live world.
struct Solo {
  explicit Solo(const std::string& name) : scene(scenarios::load_embedded(name, 5)) {
    input = shell::make_input("wander", {scene, 0, 5, {}});
    lab::SimulationConfig c;
    c.scene = scene;
    c.peers = 1;
    c.technique = technique_by_name("avatar-only");
    c.inputs = {input.get()};
    c.ticks = 1200;
    c.fidelity = true;
    simulation = std::make_unique<lab::Simulation>(std::move(c));
  }
  Scene scene;
  std::unique_ptr<scenarios::InputSource> input;
  std::unique_ptr<lab::Simulation> simulation;
};

TEST(Fidelity, WhoPlaysAloneIsPerfectToTheBit) {
  for (const char* scenario : {"arena", "clutter", "dominoes"}) {
    SCOPED_TRACE(scenario);
    const Solo solo(scenario);
    solo.simulation->run();
    EXPECT_GT(solo.simulation->fidelity()->deeds(0), 0U);
    EXPECT_EQ(solo.simulation->fidelity()->overall().peak_m, 0);
  }
}

/// `full` alone, means over six runs of 30 s, m.
struct Alone {
  explicit Alone(Unowned unowned) {
    constexpr int kRuns = 6;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
      lab::SimulationConfig c;
      c.scene = scenarios::load_embedded("arena", seed);
      c.peers = 1;
      c.technique.unowned = unowned;
      c.technique.precision = Precision::kExact;
      const auto input = shell::make_input("wander", {c.scene, 0, seed, {}});
      c.inputs = {input.get()};
      c.ticks = 1800;
      c.fidelity = true;
      lab::Simulation s(std::move(c));
      s.run();
      inconsistency += s.meter().overall().mean_m / kRuns;
      fidelity += s.fidelity()->overall().mean_m / kRuns;
    }
  }
  double inconsistency = 0;
  double fidelity = 0;
};

// Its predicted world knows the avatar by a model, which moves bodies that the avatar did not, or otherwise. Taken
// over, that is agreed, and it never happened.
TEST(Fidelity, TakingUnownedBodiesFromTheAgreedWorldIsConsistentAndLessFaithful) {
  const Alone agreed(Unowned::kAgreed);
  EXPECT_LT(agreed.inconsistency, trace::kNoiseMetres);
  EXPECT_GT(agreed.fidelity, 2 * trace::kNoiseMetres);
  const Alone live(Unowned::kLive);
  EXPECT_GT(live.inconsistency, 0.1);
  EXPECT_LT(live.fidelity, 0.001);
}

// The noise floor: the same as alone to the bit, but that every state is rounded by a sixteenth of a millimetre before
// it is looked at.
TEST(Fidelity, WhatRoundingComesTo) {
  for (const auto& [scenario, most] : {std::pair{"arena", 0.002}, {"clutter", trace::kNoiseMetres}}) {
    SCOPED_TRACE(scenario);
    const Solo solo(scenario);
    trace::FidelityMeter meter(solo.scene, 1, {0});
    solo.simulation->run([&](Tick now) {
      const world::View& live = solo.simulation->replica(0).live().world();
      std::vector<BodyState> states;
      for (EntityId e = 0; e < live.entities(); ++e) {
        states.push_back(live.state(e));
        constexpr float kGrid = 16384;
        Vec2& at = states.back().position;
        at = {std::round(at.x * kGrid) / kGrid, std::round(at.y * kGrid) / kGrid};
      }
      const trace::PlayerView view{true, states, solo.input->target(now)};
      meter.tick(now, std::span(&view, 1));
    });
    std::printf("%s: %.4f m on average, peak %.3f m\n", scenario, meter.overall().mean_m, meter.overall().peak_m);
    EXPECT_LT(meter.overall().mean_m, most);
  }
}

}  // namespace
}  // namespace padr
