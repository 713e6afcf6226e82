#include "common/shown/convergence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/model/rng.h"
#include "common/shown/tracking.h"
#include "tests/seed.h"
#include "tests/world/test_scene.h"

namespace padr::sync {
namespace {

/// One ball, and a wall at x = 20 m.
Scene one_ball() {
  return test::balls_and_a_wall(1, {0.1F, 5}, {20, 0});
}

/// A Shown of one ball, without the world.
struct OneBall {
  explicit OneBall(Convergence how) : shown(how, scene, 0), view(scene, 0) {}
  /// The ball is there, in m, and moves so fast, in m/s.
  void advance(float x, float velocity, bool own = false) {
    view.change().entities[0].position = {x, 0};
    view.change().entities[0].velocity = {velocity, 0};
    shown.advance(view, {own});
  }
  float x() const { return shown.positions()[0].x; }
  Scene scene = one_ball();
  Shown shown;
  world::View view;
};

constexpr auto kAll = {Convergence::kSnap, Convergence::kBlend, Convergence::kPvb, Convergence::kTrack};
constexpr auto kNeverJump = {Convergence::kPvb, Convergence::kTrack};

/// One entity moving at 1 m/s that is put `error` metres off at tick 10; returns the shown positions.
std::vector<float> course(OneBall& ball, float error, bool own_before, bool own_after) {
  std::vector<float> xs;
  float x = 0;
  for (Tick t = 0; t < 80; ++t) {
    x += kTickSeconds;
    if (t == 10) {
      ball.shown.correct(0, {-error, 0});
      x += error;
    }
    ball.advance(x, 1, t < 14 ? own_before : own_after);
    xs.push_back(ball.x());
  }
  return xs;
}

/// A step of the course above that is no jump, m. The fastest glide changes its step by kMostChange a tick up to half
/// of the error, and is slowed down as much thereafter.
float largest_glide(Convergence how, float error) {
  return how == Convergence::kTrack ? std::sqrt(error * kMostChange) + kTickSeconds + 0.001F : 0.12F;
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
    OneBall ball(how);
    const auto xs = course(ball, 0.5F, false, false);
    EXPECT_NEAR(xs.back(), 80 * kTickSeconds + 0.5F, 0.01F);
    if (how == Convergence::kSnap) {
      EXPECT_GT(largest_step(xs), 0.5F);
      EXPECT_EQ(ball.shown.snaps(), 1) << "going on as before after a jump is no second one";
      EXPECT_NEAR(ball.shown.snap_metres(), 0.5, 0.001);
      EXPECT_NEAR(ball.shown.largest_snap(), 0.5, 0.001);
    } else {
      EXPECT_LT(largest_step(xs), largest_glide(how, 0.5F)) << static_cast<int>(how);
    }
  }
}

// The onset of an exponential blend is a jump of a seventh of the error; the others have none.
TEST(Convergence, PvbAndTrackNeverJumpAndTakeTheLongerTheLargerTheErrorIs) {
  for (const Convergence how : kNeverJump) {
    int last = 0;
    for (const float error : {0.02F, 0.1F, 0.3F, 1.0F, 2.5F}) {
      OneBall ball(how);
      const auto xs = course(ball, error, false, false);
      EXPECT_LE(largest_change(xs), how == Convergence::kPvb ? 0.026F : kMostChange + 1e-4F) << error;
      EXPECT_EQ(ball.shown.snaps(), 0) << error;
      const int ticks = ticks_to_arrive(xs, error);
      EXPECT_GE(ticks, last) << error;
      EXPECT_LE(ticks, 40) << error;
      last = ticks;
    }
    EXPECT_GT(last, 15);
  }
  OneBall blend(Convergence::kBlend);
  EXPECT_GT(largest_change(course(blend, 0.5F, false, false)), 0.06F);
  EXPECT_GT(blend.shown.snaps(), 0);
}

// Corrections keep coming while one is being hidden: each starts from what is shown, as it moves.
TEST(Convergence, PvbAndTrackAreSmoothThroughManyCorrectionsAndKeepUp) {
  for (const Convergence how : kNeverJump) {
    OneBall ball(how);
    float x = 0;
    std::vector<float> xs;
    for (Tick t = 0; t < 300; ++t) {
      x += 3 * kTickSeconds;
      if (t % 7 == 3 && t < 200) {
        const float error = t % 2 == 0 ? 0.15F : -0.1F;
        ball.shown.correct(0, {-error, 0});
        x += error;
      }
      ball.advance(x, 3);
      xs.push_back(ball.x());
      ASSERT_LT(std::abs(xs.back() - x), 0.5F) << t;
    }
    EXPECT_LE(largest_change(xs), 0.03F);
    EXPECT_EQ(ball.shown.snaps(), 0);
    EXPECT_NEAR(xs.back(), x, 0.001F);
  }
}

// The others believed that it goes on; the update says that it has stopped 20 cm before.
TEST(Convergence, TrackDoesNotOvershootWhenSomethingStops) {
  OneBall ball(Convergence::kTrack);
  float x = 0;
  for (Tick t = 0; t < 20; ++t) ball.advance(x += 3 * kTickSeconds, 3);
  const float farthest = ball.x();
  ball.shown.correct(0, {0.2F, 0});
  x -= 0.2F;
  for (Tick t = 0; t < 40; ++t) {
    ball.advance(x, 0);
    EXPECT_LE(ball.x(), farthest) << t;
    EXPECT_GE(ball.x(), x - 1e-4F) << t;
  }
  EXPECT_EQ(ball.x(), x);
  EXPECT_EQ(ball.shown.snaps(), 0);
}

TEST(Convergence, TrackDoesNotGlideThroughAWall) {
  for (const float side : {1.0F, -1.0F}) {
    OneBall ball(Convergence::kTrack);
    ball.advance(20 - 0.6F, 0);
    ball.shown.correct(0, {side < 0 ? -0.3F : -1.2F, 0});
    const float there = 20 - 0.6F + (side < 0 ? 0.3F : 1.2F);
    ball.advance(there, 0);
    EXPECT_EQ(ball.x() == there, side > 0) << "through it: at once; up to it: not";
  }
}

// Whatever it is corrected by and however its velocity changes.
TEST(Convergence, TrackChangesNoStepByMoreThanVelocityExplainsAndTheBound) {
  Rng rng(test::seed(11));
  OneBall ball(Convergence::kTrack);
  Vec2 at;
  Vec2 velocity{1, 0};
  Vec2 before;
  Vec2 stride;
  for (Tick t = 0; t < 20000; ++t) {
    if (rng.chance(0.05)) velocity = {static_cast<float>(rng.uniform(-6, 6)), static_cast<float>(rng.uniform(-6, 6))};
    if (rng.chance(0.1)) {
      const Vec2 jump{static_cast<float>(rng.uniform(-0.4, 0.4)), static_cast<float>(rng.uniform(-0.4, 0.4))};
      ball.shown.correct(0, jump);
      at = at - jump;
    }
    at = at + velocity * kTickSeconds;
    ball.view.change().entities[0].position = at;
    ball.view.change().entities[0].velocity = velocity;
    ball.shown.advance(ball.view, {false});
    const Vec2 now = ball.shown.positions()[0];
    if (t > 1) {
      ASSERT_LE(distance_to_segment(now - before, stride, velocity * kTickSeconds), kMostChange + 1e-3F) << t;
    }
    ASSERT_LT(distance(now, at), 3) << t;
    stride = now - before;
    before = now;
  }
  EXPECT_EQ(ball.shown.snaps(), 0);
}

TEST(Convergence, WhatIsTooFarIsNotLedThroughEverything) {
  for (const Convergence how : kAll) {
    OneBall ball(how);
    EXPECT_GT(largest_step(course(ball, 4, false, false)), 4) << static_cast<int>(how);
    EXPECT_EQ(ball.shown.snaps(), 1);
  }
}

TEST(Convergence, TheOwnIsShownAsItIs) {
  for (const Convergence how : kAll) {
    OneBall ball(how);
    EXPECT_GT(largest_step(course(ball, 0.5F, true, true)), 0.5F);
  }
}

// A body that is claimed while it is led to its place goes on being led: the claim must not make it jump.
TEST(Convergence, ABlendGoesOnWhenTheBodyIsClaimed) {
  for (const Convergence how : {Convergence::kBlend, Convergence::kPvb, Convergence::kTrack}) {
    OneBall ball(how);
    const auto xs = course(ball, 0.5F, false, true);
    EXPECT_LT(largest_step(xs), largest_glide(how, 0.5F));
    EXPECT_NEAR(xs.back(), 80 * kTickSeconds + 0.5F, 0.01F);
  }
}

TEST(Convergence, ABounceIsNoJump) {
  for (const Convergence how : kNeverJump) {
    OneBall ball(how);
    float x = 0;
    for (Tick t = 0; t < 60; ++t) {
      const float v = t < 30 ? 12 : -8;
      // The bounce is in the midst of a tick: it goes on for a quarter of it.
      x += t == 30 ? (12 * 0.25F - 8 * 0.75F) * kTickSeconds : v * kTickSeconds;
      ball.advance(x, v);
    }
    EXPECT_EQ(ball.shown.snaps(), 0);
  }
}

}  // namespace
}  // namespace padr::sync
