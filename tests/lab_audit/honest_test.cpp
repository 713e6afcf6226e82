// Nobody who is honest is ever found to lie, whatever the network does and whoever comes and goes.
#include <gtest/gtest.h>

#include "common/model/rng.h"
#include "shell/netem_text.h"
#include "tests/lab_audit/recorder.h"
#include "tests/seed.h"
#include "tools/lab/chaos/play.h"

namespace padr::test {
namespace {

using lab::audit::audit;
using lab::audit::TraceText;

constexpr const char* kBadLink = "delay 100ms 50ms loss 10%";

/// All traces together, and each alone, say nothing of anybody.
void expect_nothing(const Recorder& r, std::uint64_t least_judged) {
  const lab::audit::Report all = audit(r.traces(), {});
  EXPECT_EQ(lines(all), "");
  EXPECT_GE(all.judged, least_judged);
  EXPECT_EQ(all.other_worlds.size(), 0U);
  for (const TraceText& t : r.traces()) {
    const lab::audit::Report one = audit({t}, {});
    EXPECT_EQ(lines(one), "") << "from " << t.label << " alone";
  }
}

struct Setting {
  const char* scenario;
  const char* technique;
};

class Honest : public testing::TestWithParam<Setting> {};

/// Peers join late, leave, are killed and cut off and come back; meanwhile some push bodies.
void play_lives(lab::VirtualNetwork& g, std::uint64_t seed) {
  const auto run = [&g](double s) { g.run_to(g.now() + in_micros(s)); };
  g.start({});
  for (int p = 1; p < 3; ++p) g.start(0);
  run(8);
  g.start(1);
  run(4);
  g.attract(Vec2{10, 5});
  run(3);
  g.attract({});
  g.kill(1);
  run(9);
  g.divide({{2, 1}});
  run(7);
  g.divide({});
  run(8);
  g.pause(3, true);
  run(1.5);
  g.pause(3, false);
  run(4);
  if (seed % 2 == 0) g.leave(0);
  run(5);
  g.finish();
}

TEST_P(Honest, WhateverHappens) {
  const std::uint64_t seed = test::seed(41);
  Recorder r(GetParam().scenario, seed);
  lab::VirtualNetworkConfig c;
  c.scene = r.scene();
  c.technique = technique_by_name(GetParam().technique);
  c.netem = shell::parse_netem(kBadLink);
  c.seed = seed;
  c.slots = std::min(8, static_cast<int>(c.scene.avatar.spawns.size()));
  c.wanted = 3;
  c.seal = seed % 3 == 0 ? wire::SealMode::kNone : wire::SealMode::kAuth;
  c.recording = r.hook();
  lab::VirtualNetwork g(std::move(c));
  play_lives(g, seed);
  expect_nothing(r, 200);
}

std::string setting_name(const testing::TestParamInfo<Setting>& info) {
  return std::string(info.param.scenario) + "_" + info.param.technique;
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Honest,
                         testing::Values(Setting{"arena", "full"}, Setting{"arena", "adaptive"},
                                         Setting{"arena", "fixed"}, Setting{"arena", "everything"},
                                         Setting{"clutter", "full"}, Setting{"clutter", "adaptive"},
                                         Setting{"dominoes", "full"}, Setting{"dominoes", "fixed"},
                                         Setting{"pitch", "full"}, Setting{"pitch", "fixed"}, Setting{"ball", "full"},
                                         Setting{"ball", "adaptive"}, Setting{"proxy", "full"},
                                         Setting{"proxy", "fixed"}, Setting{"van", "full"}, Setting{"van", "adaptive"}),
                         setting_name);

// A newcomer's first step is in the tick of its admission, if it wakes so late that it has heard of that before.
TEST(HonestNewcomers, StartAtFullForce) {
  const std::uint64_t seed = test::seed(5);
  Recorder r("arena", seed, 1);
  lab::VirtualNetworkConfig c;
  c.scene = r.scene();
  c.technique = technique_by_name("full");
  c.seed = seed;
  c.wanted = 1;
  c.recording = r.hook();
  lab::VirtualNetwork g(std::move(c));
  g.attract(Vec2{18, 13});
  g.start({});
  for (int p = 1; p < 9; ++p) {
    const int comes = g.start(0);
    for (int turn = 0; turn < 100; ++turn) {
      g.pause(comes, turn % 5 != 0);
      g.run_to(g.now() + lab::VirtualNetwork::kStep);
    }
    g.pause(comes, false);
    g.run_to(g.now() + in_micros(3) + p * lab::VirtualNetwork::kStep);
  }
  g.finish();
  expect_nothing(r, 10);
}

/// A member pushes bodies wherever they are, hard.
void play_pushes(Recorder& r, const char* technique, std::uint64_t seed) {
  lab::VirtualNetworkConfig c;
  c.scene = r.scene();
  c.technique = technique_by_name(technique);
  c.netem = shell::parse_netem(kBadLink);
  c.seed = seed;
  c.recording = r.hook();
  const auto bodies = static_cast<std::uint32_t>(c.scene.bodies.size());
  lab::VirtualNetwork g(std::move(c));
  g.start({});
  g.start(0);
  g.run_to(in_micros(6));
  Rng rng(seed);
  for (int i = 0; i < 20; ++i) {
    g.push(i % 2, static_cast<EntityId>(rng.below(bodies)),
           {static_cast<float>(rng.uniform(-30, 30)), static_cast<float>(rng.uniform(-30, 30))});
    g.run_to(g.now() + in_micros(0.7));
  }
  g.finish();
}

TEST(HonestPushes, AreNoLies) {
  const std::uint64_t seed = test::seed(7);
  for (const char* technique : {"full", "fixed"}) {
    Recorder r("arena", seed);
    play_pushes(r, technique, seed);
    expect_nothing(r, 100);
    const lab::audit::Report report = audit(r.traces(), {});
    EXPECT_GE(report.pushes.size(), 10U) << technique;
    for (const lab::audit::Push& p : report.pushes) EXPECT_TRUE(p.recorded) << technique;
    EXPECT_GE(audit(r.traces(), {.pushes = false}).findings.size(), 1U) << technique << ": they are no contacts";
  }
}

class HonestChaos : public testing::TestWithParam<int> {};

TEST_P(HonestChaos, IsNoLie) {
  const std::uint64_t seed = test::seed(9001) + static_cast<std::uint64_t>(GetParam());
  Recorder r("arena", seed, 12);
  lab::ChaosPlay how;
  how.scene = r.scene();
  how.technique = technique_by_name("full");
  how.seal = seed % 2 == 0 ? wire::SealMode::kAuth : wire::SealMode::kNone;
  how.recording = r.hook();
  EXPECT_EQ(lab::play(how, lab::make_script(seed, in_micros(60), 8)).violation, "");
  const lab::audit::Report all = audit(r.traces(), {});
  EXPECT_EQ(lines(all), "");
  EXPECT_GE(all.judged, 200U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, HonestChaos, testing::Range(0, 6));

}  // namespace
}  // namespace padr::test
