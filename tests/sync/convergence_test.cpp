#include "common/shown/convergence.h"

#include <gtest/gtest.h>

#include <cmath>

namespace padr::sync {
namespace {

/// There, in m, moving so fast, in m/s.
world::Kinematics at(float x, float velocity) {
  world::Kinematics k;
  k.position = {x, 0};
  k.velocity = {velocity, 0};
  return k;
}

constexpr auto kAll = {Convergence::kSnap, Convergence::kBlend, Convergence::kPvb};

/// One entity moving at 1 m/s that is put `error` metres off at tick 10; returns the shown positions.
std::vector<float> course(Shown& shown, float error, bool own_before, bool own_after) {
  std::vector<float> xs;
  float x = 0;
  for (Tick t = 0; t < 80; ++t) {
    x += kTickSeconds;
    if (t == 10) {
      shown.correct(0, {-error, 0});
      x += error;
    }
    shown.advance({at(x, 1)}, {t < 14 ? own_before : own_after});
    xs.push_back(shown.positions()[0].x);
  }
  return xs;
}

float largest_step(const std::vector<float>& xs) {
  float largest = 0;
  for (std::size_t i = 1; i < xs.size(); ++i) largest = std::max(largest, xs[i] - xs[i - 1]);
  return largest;
}

/// From one step to the next.
float largest_change(const std::vector<float>& xs) {
  float largest = 0;
  for (std::size_t i = 2; i < xs.size(); ++i)
    largest = std::max(largest, std::abs((xs[i] - xs[i - 1]) - (xs[i - 1] - xs[i - 2])));
  return largest;
}

/// Ticks from the correction until the shown position is within a millimetre of the true one for good.
int ticks_to_arrive(const std::vector<float>& xs, float error) {
  for (std::size_t i = xs.size(); i-- > 10;)
    if (std::abs(xs[i] - (static_cast<float>(i + 1) * kTickSeconds + error)) > 0.001F) return static_cast<int>(i) - 9;
  return 0;
}

TEST(Convergence, SnapJumpsBlendsDoNotAndAllArrive) {
  for (const Convergence how : kAll) {
    Shown shown(how, 1);
    const auto xs = course(shown, 0.5F, false, false);
    EXPECT_NEAR(xs.back(), 80 * kTickSeconds + 0.5F, 0.01F);
    if (how == Convergence::kSnap) {
      EXPECT_GT(largest_step(xs), 0.5F);
      EXPECT_EQ(shown.snaps(), 1) << "going on as before after a jump is no second one";
      EXPECT_NEAR(shown.snap_metres(), 0.5, 0.001);
      EXPECT_NEAR(shown.largest_snap(), 0.5, 0.001);
    } else {
      EXPECT_LT(largest_step(xs), 0.12F) << static_cast<int>(how);
    }
  }
}

// The onset of an exponential blend is a jump of a seventh of the error; projective velocity blending has none.
TEST(Convergence, PvbNeverJumpsAndTakesTheLongerTheLargerTheErrorIs) {
  int last = 0;
  for (const float error : {0.02F, 0.1F, 0.3F, 1.0F, 2.5F}) {
    Shown pvb(Convergence::kPvb, 1);
    const auto xs = course(pvb, error, false, false);
    EXPECT_LE(largest_change(xs), 0.026F) << error;
    EXPECT_EQ(pvb.snaps(), 0) << error;
    const int ticks = ticks_to_arrive(xs, error);
    EXPECT_GE(ticks, last) << error;
    EXPECT_LE(ticks, 40) << error;
    last = ticks;
  }
  EXPECT_GT(last, 20);
  Shown blend(Convergence::kBlend, 1);
  EXPECT_GT(largest_change(course(blend, 0.5F, false, false)), 0.06F);
  EXPECT_GT(blend.snaps(), 0);
}

// Corrections keep coming while one is being hidden: each starts from what is shown, as it moves.
TEST(Convergence, PvbIsSmoothThroughManyCorrectionsAndKeepsUp) {
  Shown shown(Convergence::kPvb, 1);
  float x = 0;
  std::vector<float> xs;
  for (Tick t = 0; t < 300; ++t) {
    x += 3 * kTickSeconds;
    if (t % 7 == 3 && t < 200) {
      const float error = t % 2 == 0 ? 0.15F : -0.1F;
      shown.correct(0, {-error, 0});
      x += error;
    }
    shown.advance({at(x, 3)}, {false});
    xs.push_back(shown.positions()[0].x);
    ASSERT_LT(std::abs(xs.back() - x), 0.5F) << t;
  }
  EXPECT_LE(largest_change(xs), 0.03F);
  EXPECT_EQ(shown.snaps(), 0);
  EXPECT_NEAR(xs.back(), x, 0.001F);
}

TEST(Convergence, WhatIsTooFarIsNotLedThroughEverything) {
  for (const Convergence how : kAll) {
    Shown shown(how, 1);
    EXPECT_GT(largest_step(course(shown, 4, false, false)), 4) << static_cast<int>(how);
    EXPECT_EQ(shown.snaps(), 1);
  }
}

TEST(Convergence, TheOwnIsShownAsItIs) {
  for (const Convergence how : kAll) {
    Shown shown(how, 1);
    EXPECT_GT(largest_step(course(shown, 0.5F, true, true)), 0.5F);
  }
}

// A body that is claimed while it is led to its place goes on being led: the claim must not make it jump.
TEST(Convergence, ABlendGoesOnWhenTheBodyIsClaimed) {
  for (const Convergence how : {Convergence::kBlend, Convergence::kPvb}) {
    Shown shown(how, 1);
    const auto xs = course(shown, 0.5F, false, true);
    EXPECT_LT(largest_step(xs), 0.12F);
    EXPECT_NEAR(xs.back(), 80 * kTickSeconds + 0.5F, 0.01F);
  }
}

TEST(Convergence, ABounceIsNoJump) {
  Shown shown(Convergence::kPvb, 1);
  float x = 0;
  for (Tick t = 0; t < 60; ++t) {
    const float v = t < 30 ? 12 : -8;
    // The bounce is in the midst of a tick: it goes on for a quarter of it.
    x += t == 30 ? (12 * 0.25F - 8 * 0.75F) * kTickSeconds : v * kTickSeconds;
    shown.advance({at(x, v)}, {false});
  }
  EXPECT_EQ(shown.snaps(), 0);
}

}  // namespace
}  // namespace padr::sync
