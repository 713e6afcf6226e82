#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "tests/seed.h"
#include "tools/lab/convergence/film.h"

namespace padr::lab::convergence {
namespace {

struct Session {
  Session() {
    const std::uint64_t seed = test::seed(3);
    config.scene = scenarios::load_embedded("arena", seed);
    config.peers = 3;
    config.netem = shell::parse_netem("delay 100ms 30ms loss 2%");
    config.netem_seed = seed;
    config.ticks = 100 * kTicksPerSecond;  // in 25 s the methods jump by half a metre, and one jump decides
    for (int p = 0; p < 3; ++p) {
      inputs.push_back(shell::make_input("wander", {config.scene, p, seed, {}}));
      config.inputs.push_back(inputs.back().get());
    }
  }
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  SimulationConfig config;
};

TEST(LabConvergence, OnlyWhatIsShownDiffersAndTheDefaultLooksBest) {
  const Session session;
  Takes takes(session.config, 1);
  takes.run();
  std::array<double, kMethods.size()> jumped{};
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    for (PeerId p = 0; p < 3; ++p) {
      EXPECT_EQ(takes.simulations[m]->replica(p).live_hash(), takes.simulations[0]->replica(p).live_hash());
      jumped[m] += takes.simulations[m]->replica(p).shown().snap_metres();
    }
  }
  EXPECT_LT(jumped[1], jumped[0] / 4) << "blend against snap";
  EXPECT_LT(jumped[2], jumped[1] / 4) << "pvb against blend";
  EXPECT_LE(jumped[3], jumped[2]) << "track against pvb";
  EXPECT_EQ(Technique{}.convergence, Convergence::kTrack);
  // What smoothness costs: what is shown is later.
  const auto shown_m = [&](std::size_t m) { return takes.simulations[m]->meter().overall().shown_mean_m; };
  EXPECT_LT(shown_m(2), 1.3 * shown_m(1));
  EXPECT_LT(shown_m(3), 0.8 * shown_m(2));
  std::array<trace::ShownMotion, kMethods.size()> motion{};
  for (std::size_t m = 0; m < kMethods.size(); ++m)
    for (PeerId p = 0; p < 3; ++p) motion[m].add(takes.simulations[m]->shown(p));
  EXPECT_EQ(motion[0].overlap_m, 0) << "what jumps is shown where it is";
  EXPECT_LT(motion[3].overlap_m, 0.6 * motion[2].overlap_m);
  EXPECT_LT(motion[3].overlap_made_m, 0.5 * motion[2].overlap_made_m);
  EXPECT_LT(motion[3].overshoot_peak_m, 0.05);

  const plot::FilmStrip film = film_of(takes.footage, session.config.scene);
  ASSERT_EQ(film.rows.size(), 2U) << "an avatar and a body";
  for (const plot::FilmRow& row : film.rows) EXPECT_EQ(row.frames.size(), kMethods.size());
}

/// Two entities, a body and an avatar, that move by 0.1 m a tick; each is put aside once.
TEST(LabConvergence, TheLargestCorrectionIsFound) {
  Footage f;
  f.viewer = 1;
  for (int t = 0; t < 100; ++t) {
    const float x = 0.1F * static_cast<float>(t);
    const Vec2 body{x, t < 40 ? 0.0F : 0.7F};
    const Vec2 avatar{x, (t < 50 ? 5.0F : 5.4F) + (t < 70 ? 0.0F : 2.0F)};
    for (auto& shown : f.shown) shown.push_back({body, avatar});
    f.truth.push_back({body, avatar});
    f.foreign.push_back({t < 60, true});
  }
  const Moment avatar = largest_correction(f, 1, false, 1, 5, 5);
  EXPECT_EQ(avatar.tick, 50) << "the one of 2 m at tick 70 is more than was asked for";
  EXPECT_NEAR(avatar.metres, 0.4, 1e-4);
  EXPECT_EQ(largest_correction(f, 1, false, 3, 5, 5).tick, 70);
  EXPECT_EQ(largest_correction(f, 1, true, 1, 5, 5).tick, 40);
  EXPECT_EQ(largest_correction(f, 1, true, 1, 5, 20).tick, 40);
  EXPECT_LT(largest_correction(f, 1, true, 1, 5, 21).metres, 1e-3F) << "by then the body is the viewer's own";
}

}  // namespace
}  // namespace padr::lab::convergence
