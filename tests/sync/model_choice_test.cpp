#include "common/reckoning/model_choice.h"

#include <gtest/gtest.h>

#include "common/reckoning/aim.h"
#include "common/world/avatar_control.h"

namespace padr::sync {
namespace {

/// An avatar in the open, and the choice of its model.
class Walk {
 public:
  /// One tick towards the target, m.
  void step(Vec2 target) {
    const Vec2 force = world::control_force(avatar_, state_.position, state_.velocity, target);
    const Vec2 acceleration = force * (1 / avatar_.mass);
    state_.velocity = state_.velocity + acceleration * kTickSeconds;
    state_.position = state_.position + state_.velocity * kTickSeconds;
    aim_.follow(target);
    choice_.follow(state_, aim_.ahead(), acceleration, 6);
    target_ = target;
  }
  void run(Vec2 velocity, int ticks) {
    for (int i = 0; i < ticks; ++i) step(target_ + velocity * kTickSeconds);
  }
  /// From place to place, as a hand points: there in a fifth of a second, and a pause.
  void point(int times) {
    for (int i = 0; i < times; ++i) {
      run({i % 2 == 0 ? 5.0F : -5.0F, 0}, 12);
      run({}, 18);
    }
  }
  Model best() const { return choice_.best(); }

 private:
  static AvatarDef person() {
    AvatarDef d;
    d.stiffness = 40;
    d.damping = 10;
    d.max_force = 1600;
    d.max_speed = 6;
    return d;
  }

  AvatarDef avatar_ = person();
  BodyState state_;
  Aim aim_{0.05F};
  ModelChoice choice_{avatar_};
  Vec2 target_;
};

TEST(ModelChoice, IsWhereItHeadsUntilSomethingElseIsKnown) {
  Walk w;
  EXPECT_EQ(w.best(), Model::kInput);
  w.run({}, 60);
  EXPECT_EQ(w.best(), Model::kInput) << "both are right about an avatar that stands";
}

TEST(ModelChoice, OfAHandThatPointsIsWhereItHeads) {
  Walk w;
  for (int i = 0; i < 20; ++i) {
    w.point(1);
    EXPECT_EQ(w.best(), Model::kInput) << "after " << i + 1;
  }
}

TEST(ModelChoice, OfARunnerIsVelocityAndAccelerationWithinASecondAndAHalf) {
  Walk w;
  w.point(4);
  w.run({4, 0}, 90);
  EXPECT_EQ(w.best(), Model::kSecond);
  w.run({3, 2}, 60);
  EXPECT_EQ(w.best(), Model::kSecond) << "it has only turned";
}

TEST(ModelChoice, OfARunnerThatBeginsToPointIsWhereItHeadsAgain) {
  Walk w;
  w.run({4, 0}, 120);
  ASSERT_EQ(w.best(), Model::kSecond);
  w.point(4);
  EXPECT_EQ(w.best(), Model::kInput);
}

}  // namespace
}  // namespace padr::sync
