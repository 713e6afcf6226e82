// Contacts that figures and scores are made of are those that really were.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/scenarios/scenarios.h"
#include "shell/input_text.h"
#include "tests/seed.h"
#include "tools/lab/figures/run.h"
#include "tools/lab/simulation.h"

namespace padr::lab::figures {
namespace {

constexpr Tick kTicks = 15 * kTicksPerSecond;

/// By tick from 1 on: whether the first peer has announced that its avatar touches some body, as the confirmed world
/// has it.
std::vector<bool> announced(const Case& c, const Setting& s) {
  const auto driver = shell::make_input(c.input, {c.scene, 0, c.seed, {}});
  const auto watcher = shell::make_input("rest", {c.scene, 1, c.seed, {}});
  std::vector<bool> holds(kTicks, false);
  SimulationConfig config;
  config.scene = c.scene;
  config.technique = s.technique;
  config.netem_seed = c.seed;
  config.inputs = {driver.get(), watcher.get()};
  config.ticks = kTicks;
  config.settle_ticks = 5 * kTicksPerSecond;
  config.on_confirmed = [&holds](PeerId p, const sync::FoldState& f) {
    if (p != 0 || f.tick < 2 || f.tick > kTicks + 1) return;  // a state has the updates of the ticks before
    for (const PeerSet h : f.holds)
      if ((h & only(0)) != 0) holds[static_cast<std::size_t>(f.tick - 2)] = true;
  };
  Simulation(std::move(config)).run();
  return holds;
}

TEST(FigureContacts, AreThoseThatThePeerAnnouncesTickByTick) {
  const std::vector<Setting> settings = figure_settings();
  const std::uint64_t first = test::seed(1);
  std::ptrdiff_t all = 0;
  for (std::uint64_t seed = first; seed < first + 10; ++seed) {
    const Case c{"wander", "", "wander", "wander", seed, scenarios::load_embedded("arena", seed)};
    for (const std::string& id : {std::string("fixed-0.5"), adaptive_id("lookahead")}) {
      const Setting& s = settings[setting_index(settings, id)];
      const FigureRun run = run_figure(c, s, {}, kTicks);
      const std::vector<bool> told = announced(c, s);
      ASSERT_EQ(run.touching.size(), told.size());
      for (std::size_t t = 0; t < told.size(); ++t)
        ASSERT_EQ(run.touching[t], told[t]) << id << ", seed " << seed << ", tick " << t + 1;
      all += std::count(told.begin(), told.end(), true);
    }
  }
  EXPECT_GT(all, 500);
}

}  // namespace
}  // namespace padr::lab::figures
