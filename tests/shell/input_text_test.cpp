#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "common/scenarios/scenarios.h"
#include "common/scenarios/wander.h"
#include "shell/input_text.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using shell::InputContext;
using shell::make_input;
using testing::error_of;
using testing::first_seed;

std::string read_file(const std::string& file) {
  if (file == "a.csv") return "t,x,y\n0,1,1\n1,3,1\n";
  if (file == "bad.csv") return "t,x,y\n0,1,oops\n";
  throw UserError(file + ": no such file");
}

TEST(Input, EachSpecificationGivesItsSource) {
  const Scene scene = load_embedded("arena", 1);
  const InputContext context{scene, 1, 7, read_file};
  const auto at = [&](const std::string& spec, Tick tick) { return make_input(spec, context)->target(tick); };
  EXPECT_EQ(at("rest", 0), scene.avatar.spawns[1]);
  EXPECT_EQ(at("rest", 1'000'000), scene.avatar.spawns[1]);
  EXPECT_EQ(at("path:a.csv", 0), (Vec2{1, 1}));
  EXPECT_EQ(at("path:a.csv", 30), (Vec2{2, 1}));
  EXPECT_EQ(at("path:a.csv", 60), (Vec2{3, 1}));
  EXPECT_EQ(at("path:a.csv", 90), (Vec2{3, 1}));
  EXPECT_EQ(at("path:a.csv,loop", 59), at("path:a.csv", 59));
  EXPECT_EQ(at("path:a.csv,loop", 60), (Vec2{1, 1}));
  EXPECT_EQ(at("path:a.csv,loop", 90), (Vec2{2, 1}));
  EXPECT_EQ(at("wander", 0), scene.avatar.spawns[1]);
  EXPECT_EQ(at("wander", 500), at("wander:7", 500)) << "the context's seed is the one taken when none is named";
  EXPECT_NE(at("wander", 500), at("wander:8", 500));
  EXPECT_NE(at("wander:18446744073709551615", 500), at("wander:0", 500));
}

TEST(Input, MistakesAreNamed) {
  const Scene scene = load_embedded("van", 1);
  const auto error = [&](const std::string& spec, int slot = 0) {
    return error_of([&] { make_input(spec, {scene, slot, 1, read_file}); });
  };
  const std::string seeds = "has no seed after the colon, allowed: wander:0 .. wander:18446744073709551615";
  EXPECT_EQ(error(""), "input: \"\" is no input, allowed: path:FILE, path:FILE,loop, wander, wander:SEED or rest");
  EXPECT_EQ(error("wonder"),
            "input: \"wonder\" is no input, allowed: path:FILE, path:FILE,loop, wander, wander:SEED or rest");
  EXPECT_EQ(error("wander:"), "input: \"wander:\" " + seeds);
  EXPECT_EQ(error("wander:-1"), "input: \"wander:-1\" " + seeds);
  EXPECT_EQ(error("wander:7x"), "input: \"wander:7x\" " + seeds);
  EXPECT_EQ(error("wander:18446744073709551616"), "input: \"wander:18446744073709551616\" " + seeds);
  EXPECT_EQ(error("path:"), "input: \"path:\" names no file, allowed: path:FILE or path:FILE,loop");
  EXPECT_EQ(error("path:,loop"), "input: \"path:,loop\" names no file, allowed: path:FILE or path:FILE,loop");
  EXPECT_EQ(error("path:gone.csv"), "gone.csv: no such file");
  EXPECT_EQ(error("path:bad.csv,loop"), "bad.csv:2:5: y is \"oops\", not a number, allowed: -10000 .. 10000 m");
  EXPECT_EQ(error("rest", 4), "input: \"rest\" is for avatar slot 4, allowed in scenario van: 0 .. 3");
  EXPECT_EQ(error("rest", -1), "input: \"rest\" is for avatar slot -1, allowed in scenario van: 0 .. 3");
}

TEST(Input, DependsOnTheTickAlone) {
  const Scene scene = load_embedded("arena", 1);
  for (const std::string spec : {"wander", "path:a.csv,loop", "rest"}) {
    const InputContext context{scene, 0, 3, read_file};
    const auto steady = make_input(spec, context);
    std::vector<Vec2> every;
    for (Tick t = 0; t < 3 * 3600; ++t) every.push_back(steady->target(t));
    EXPECT_TRUE(rc::check(spec + " asked at random", [&] {
      const auto random = make_input(spec, context);
      for (int i = 0; i < 20; ++i) {
        const Tick t = *rc::gen::inRange<Tick>(0, 3 * 3600);
        RC_ASSERT(random->target(t) == every[static_cast<std::size_t>(t)]);
      }
    }));
    EXPECT_EQ(steady->target(-1), every[0]);
  }
}

struct Motion {
  float top = 0;         ///< m/s
  double metres = 0;     ///< gone in all
  int resting = 0;       ///< ticks without motion
  int longest_rest = 0;  ///< ticks
  Vec2 low, high;        ///< m
};

Motion observe(InputSource& input, Tick ticks) {
  Motion m;
  Vec2 before = input.target(0);
  m.low = m.high = before;
  int rest = 0;
  for (Tick t = 1; t < ticks; ++t) {
    const Vec2 now = input.target(t);
    const float step = distance(now, before);
    m.top = std::max(m.top, step * kTicksPerSecond);
    m.metres += static_cast<double>(step);
    rest = step > 0 ? 0 : rest + 1;
    m.resting += step > 0 ? 0 : 1;
    m.longest_rest = std::max(m.longest_rest, rest);
    m.low = {std::min(m.low.x, now.x), std::min(m.low.y, now.y)};
    m.high = {std::max(m.high.x, now.x), std::max(m.high.y, now.y)};
    before = now;
  }
  return m;
}

TEST(Wander, StaysInsideAndMovesLikeAPersonInEveryScenario) {
  const std::uint64_t first = first_seed();
  constexpr Tick kTicks = 5 * 60 * kTicksPerSecond;
  for (const auto name : embedded_names()) {
    const Scene scene = load_embedded(name, 1);
    for (std::uint64_t seed = first; seed < first + 20; ++seed) {
      Wander wander(wander_options(scene, 0), seed);
      const Motion m = observe(wander, kTicks);
      const std::string what = std::string(name) + " seed " + std::to_string(seed);
      EXPECT_TRUE(m.low.x >= scene.lower.x && m.low.y >= scene.lower.y) << what;
      EXPECT_TRUE(m.high.x <= scene.upper.x && m.high.y <= scene.upper.y) << what;
      // All over the place, not in a corner of it.
      EXPECT_GT(m.high.x - m.low.x, 0.6F * (scene.upper.x - scene.lower.x)) << what;
      EXPECT_GT(m.high.y - m.low.y, 0.6F * (scene.upper.y - scene.lower.y)) << what;
      // As fast as the avatar can follow; on average about half that, with rests, none of them long.
      EXPECT_LE(m.top, scene.avatar.max_speed) << what;
      EXPECT_GE(m.top, 0.7F * scene.avatar.max_speed) << what;
      const double mean = m.metres / 300;
      EXPECT_GT(mean, 0.2 * static_cast<double>(scene.avatar.max_speed)) << what;
      EXPECT_LT(mean, 0.6 * static_cast<double>(scene.avatar.max_speed)) << what;
      EXPECT_GT(m.resting, kTicks / 50) << what;
      EXPECT_LT(m.longest_rest, (name == "pitch" ? 40 : 12) * kTicksPerSecond) << what;
    }
  }
}

TEST(Wander, SlotsAndSeedsWanderApart) {
  const Scene scene = load_embedded("arena", 1);
  WanderOptions options = wander_options(scene, 0);
  Wander a(options, 1);
  Wander b(options, 2);
  options.slot = 1;
  Wander c(options, 1);
  double ab = 0;
  double ac = 0;
  for (Tick t = 0; t < 3600; ++t) {
    ab += static_cast<double>(distance(a.target(t), b.target(t))) / 3600;
    ac += static_cast<double>(distance(a.target(t), c.target(t))) / 3600;
  }
  EXPECT_GT(ab, 2);
  EXPECT_GT(ac, 2);
}

TEST(Wander, HasNoJumpsWhereChaptersMeetNorAtTheEndOfTime) {
  const Scene scene = load_embedded("pitch", 1);
  Wander wander(wander_options(scene, 3), first_seed());
  const float most = scene.avatar.max_speed * kTickSeconds;
  for (const Tick begin : {0, 1'000'000, std::numeric_limits<Tick>::max() - 20'000}) {
    Vec2 before = wander.target(begin);
    for (Tick t = begin + 1; t < begin + 20'000; ++t) {
      const Vec2 now = wander.target(t);
      ASSERT_LE(distance(now, before), most) << "tick " << t;
      before = now;
    }
  }
}

}  // namespace
}  // namespace padr::scenarios
