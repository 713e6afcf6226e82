#include "common/reckoning/model_choice.h"

#include <gtest/gtest.h>

#include "common/reckoning/aim.h"
#include "common/sync/avatar_model.h"
#include "common/world/avatar_control.h"
#include "tests/world/test_scene.h"

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
    choice_.follow(state_, aim_.ahead(6), acceleration, 6);
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
  Aim aim_{0.04F};
  ModelChoice choice_{avatar_};
  Vec2 target_;
};

TEST(Foretold, IsWhereAWorldHasTheAvatarThatItsModelMoves) {
  const Scene scene = test::busy_scene(1, 0);
  const AvatarMoment from{{4, 4}, {1, 2}, {9, 3}, {3, -2}};
  for (const Model model : {Model::kStatic, Model::kFirst, Model::kSecond, Model::kInput}) {
    world::World w(scene, 1);
    const EntityId avatar = w.avatar(0);
    w.set_present(avatar, true);
    BodyState s = w.state(avatar);
    s.position = from.position;
    s.velocity = from.velocity;
    s.awake = true;
    w.set_state(avatar, s);
    const AvatarModel told{true, model, from.velocity, model == Model::kInput ? from.aim : from.acceleration, 0, false};
    for (Tick t = 0; t < 6; ++t) {
      drive_model(w, 0, told, t);
      w.step();
    }
    const Vec2 there = ModelChoice(scene.avatar).foretold(model, from, 6);
    EXPECT_NEAR(there.x, w.position(avatar).x, 0.002F) << static_cast<int>(model);
    EXPECT_NEAR(there.y, w.position(avatar).y, 0.002F) << static_cast<int>(model);
  }
}

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
