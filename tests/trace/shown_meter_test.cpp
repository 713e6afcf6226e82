#include "common/trace/shown_meter.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/world/test_scene.h"

namespace padr::trace {
namespace {

constexpr float kTick = kTickSeconds;

/// Two balls of 0.3 m, the second one far away, and a wall from x = 20 m on.
Scene two_balls() {
  return test::balls_and_a_wall(2, {1, 10}, {21, 0});
}

/// The first ball at a tick, along x.
struct At {
  float live = 0;   ///< m
  float speed = 0;  ///< m/s
  float shown = 0;  ///< m
};

constexpr float kFarAway = 100;  // m

ShownMotion measured(Tick ticks, const std::function<At(Tick)>& course, float second = kFarAway, bool there = true) {
  ShownMeter meter(two_balls(), 0);
  for (Tick t = 0; t < ticks; ++t) {
    const At a = course(t);
    const std::vector<BodyState> live{{{a.live, 0}, 0, {a.speed, 0}, 0, true}, {{second, 0}, 0, {}, 0, true}};
    meter.tick(live, std::vector<Vec2>{{a.shown, 0}, {second, 0}}, {true, there});
  }
  return meter.result();
}

At steady(Tick t, float speed = 3) {
  const float x = static_cast<float>(t) * speed * kTick;
  return {x, speed, x};
}

TEST(ShownMeter, SteadyMotionHasNothing) {
  const ShownMotion m = measured(100, [](Tick t) { return steady(t); });
  EXPECT_EQ(m.ticks, 100U);
  EXPECT_EQ(m.stride_change_m, 0);
  EXPECT_EQ(m.unexplained_m, 0);
  EXPECT_EQ(m.stops, 0U);
  EXPECT_EQ(m.overlap_m, 0);
  EXPECT_EQ(m.freezes, 0U);
}

TEST(ShownMeter, AJumpChangesTheStepTwiceAndIsUnexplainedOnce) {
  const ShownMotion m = measured(100, [](Tick t) {
    At a = steady(t);
    a.shown += t < 50 ? 0 : 0.5F;
    return a;
  });
  EXPECT_NEAR(m.stride_change_m, 0.5 + 0.5, 0.01);
  EXPECT_NEAR(m.unexplained_m, 0.5, 0.01);
}

TEST(ShownMeter, ABounceChangesTheStepAndIsExplained) {
  const ShownMotion m = measured(100, [](Tick t) { return t < 50 ? steady(t) : steady(100 - t, 3); });
  const ShownMotion bounce = measured(100, [](Tick t) {
    At a = t <= 50 ? steady(t) : steady(100 - t);
    a.speed = t <= 50 ? 3 : -3;
    return a;
  });
  EXPECT_NEAR(bounce.stride_change_m, 2 * 3 * kTick, 1e-4);
  EXPECT_NEAR(bounce.unexplained_m, 0, 1e-4);
  EXPECT_GT(m.unexplained_m, 0.09) << "the same way back without a velocity that says so";
}

/// At 3 m/s until tick 50, then still; from then on shown `beyond` m ahead of that.
At stopping(Tick t, const std::function<float(Tick)>& beyond) {
  if (t <= 50) return steady(t);
  const float x = 50 * 3 * kTick;
  return {x, 0, x + beyond(t - 50)};
}

TEST(ShownMeter, OvershootIsHowFarItIsShownBeyondTheStop) {
  const auto there_and_back = [](Tick since) { return since < 5 ? 0.02F * static_cast<float>(since) : 0; };
  const ShownMotion m = measured(100, [&](Tick t) { return stopping(t, there_and_back); });
  EXPECT_EQ(m.stops, 1U);
  EXPECT_NEAR(m.overshoot_peak_m, 0.08, 1e-4);
  EXPECT_NEAR(m.overshoot_mean_m(), 0.08, 1e-4);
}

// The live world had it 30 cm farther until the update came that it has stopped: that is inconsistency, not overshoot.
TEST(ShownMeter, WhatTheLiveWorldOvershotIsNotCounted) {
  for (const float beyond : {0.3F, 0.34F}) {
    const ShownMotion m = measured(100, [&](Tick t) {
      if (t <= 50) return steady(t);
      const float x = 50 * 3 * kTick;
      return At{x - 0.3F, 0, x + (t < 60 ? beyond - 0.3F : -0.3F)};
    });
    EXPECT_EQ(m.stops, 1U);
    EXPECT_NEAR(m.overshoot_peak_m, beyond - 0.3F, 1e-4);
  }
}

TEST(ShownMeter, SlowingDownIsNoStopAndAGradualStopIsOne) {
  const auto to = [](float speed, Tick within) {
    return measured(200,
                    [=, x = 0.0F](Tick t) mutable {
                      const float part =
                          std::min(1.0F, static_cast<float>(std::max(0, t - 50)) / static_cast<float>(within));
                      const float v = 3 + (speed - 3) * part;
                      x += v * kTick;
                      return At{x, v, x};
                    })
        .stops;
  };
  EXPECT_EQ(to(0.5F, 10), 0U);
  EXPECT_EQ(to(0, 10), 1U);
  EXPECT_EQ(to(0, 20), 1U);
  EXPECT_EQ(to(0, 60), 0U) << "it rolls out";
}

TEST(ShownMeter, OverlapIsWhatIsShownBeyondTheLiveWorld) {
  // From tick 50 on it is shown 10 cm into the other ball, which the live world never has.
  const auto into = [](Tick t) { return At{0, 0, t < 50 ? 0 : 0.5F}; };
  const ShownMotion made = measured(60, into, 1);
  EXPECT_NEAR(made.overlap_m, 10 * 0.1, 1e-4);
  EXPECT_NEAR(made.overlap_made_m, 10 * 0.1, 1e-4);
  EXPECT_NEAR(made.overlap_peak_m, 0.1, 1e-5);
  EXPECT_EQ(measured(60, into, 1, false).overlap_m, 0) << "the other one is not there";

  // The live world has it, until it is corrected; what is shown follows within 10 ticks.
  const ShownMotion had = measured(
      100,
      [](Tick t) {
        if (t < 50) return At{0.5F, 0, 0.5F};
        return At{0, 0, std::max(0.0F, 0.5F - 0.01F * static_cast<float>(t - 49))};
      },
      1);
  EXPECT_NEAR(had.overlap_m, 0.09 + 0.08 + 0.07 + 0.06 + 0.05 + 0.04 + 0.03 + 0.02 + 0.01, 1e-4);
  EXPECT_EQ(had.overlap_made_m, 0);

  const ShownMotion live = measured(
      100,
      [](Tick) {
        return At{0.5F, 0, 0.5F};
      },
      1);
  EXPECT_EQ(live.overlap_m, 0);
  const ShownMotion wall = measured(1, [](Tick) { return At{19, 0, 19.9F}; });
  EXPECT_NEAR(wall.overlap_peak_m, 0.2, 1e-5);
}

TEST(ShownMeter, AFreezeIsATenthOfASecond) {
  const auto standing = [](Tick ticks) {
    return measured(200, [=](Tick t) {
      At a = steady(t, 1);
      if (t > 50 && t <= 50 + ticks) a.shown = steady(50, 1).shown;
      return a;
    });
  };
  EXPECT_EQ(standing(5).freezes, 0U);
  EXPECT_EQ(standing(6).freezes, 1U);
  EXPECT_EQ(standing(20).freezes, 1U);
  EXPECT_EQ(standing(20).longest_freeze, 20);
  const ShownMotion both = measured(200, [](Tick) { return At{0, 1, 0}; });
  EXPECT_EQ(both.freezes, 0U) << "it stands in the live world, too";
}

TEST(ShownMeter, SumsOfSeveralViews) {
  ShownMotion all;
  const auto there_and_back = [](Tick since) { return since < 5 ? 0.02F * static_cast<float>(since) : 0; };
  all.add(measured(100, [&](Tick t) { return stopping(t, there_and_back); }));
  all.add(measured(100, [](Tick t) { return stopping(t, [](Tick) { return 0.0F; }); }));
  EXPECT_EQ(all.stops, 2U);
  EXPECT_EQ(all.ticks, 200U);
  EXPECT_NEAR(all.overshoot_mean_m(), 0.04, 1e-4);
  EXPECT_NEAR(all.overshoot_peak_m, 0.08, 1e-4);
}

}  // namespace
}  // namespace padr::trace
