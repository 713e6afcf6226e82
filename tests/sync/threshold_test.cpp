#include "common/reckoning/threshold.h"

#include <gtest/gtest.h>

#include "tests/world/test_scene.h"

namespace padr::sync {
namespace {

Technique adaptive(Predictor p) {
  Technique t = technique_by_name("adaptive");
  t.predictor = p;
  return t;
}

struct Fixture {
  Scene scene = test::corridor();
  world::World live{scene, 1};
  FoldState modelled;
  explicit Fixture() {
    live.set_present(live.avatar(0), true);
    live.set_free(0, true);
    live.save(modelled.world);
    modelled.avatars.resize(1);
    modelled.avatars[0].present = true;
  }
  Prediction ask(Predictor p, Vec2 target) {
    InteractionPredictor predictor(scene, 1, 0, adaptive(p));
    world::View seen(scene, 1);
    live.save(seen.change());
    return predictor.predict(seen, target, modelled);
  }
};

TEST(Prediction, LookaheadSeesTheContactOnTheWayAndNoneElsewhere) {
  Fixture f;
  f.live.set_velocity(f.live.avatar(0), {6, 0});
  const Prediction towards = f.ask(Predictor::kLookahead, {8, 4});
  EXPECT_TRUE(towards.interaction);
  EXPECT_GT(towards.contact_in, 15);  // 2.1 m at 6 m/s: 21 ticks
  EXPECT_LT(towards.contact_in, 27);
  f.live.set_velocity(f.live.avatar(0), {0, 3});
  EXPECT_FALSE(f.ask(Predictor::kLookahead, {2, 7}).interaction);
}

TEST(Prediction, PccIsTheDifferenceThatTheModelErrorMakes) {
  Fixture f;
  f.live.set_velocity(f.live.avatar(0), {6, 0});
  f.live.save(f.modelled.world);
  f.modelled.avatars[0].kind = Model::kInput;
  f.modelled.avatars[0].control = {8, 4};
  EXPECT_LT(f.ask(Predictor::kPcc, {8, 4}).cost_m, 0.001F) << "a right model costs nothing, contact or not";
  f.modelled.avatars[0].control = {2, 7};  // believed to turn away
  const Prediction wrong = f.ask(Predictor::kPcc, {8, 4});
  EXPECT_GT(wrong.cost_m, 0.1F);
  EXPECT_TRUE(wrong.interaction);
}

TEST(Prediction, DensityCountsWhatIsNear) {
  Fixture f;
  EXPECT_FALSE(f.ask(Predictor::kDensity, {8, 4}).interaction) << "one body, four wanted";
  EXPECT_TRUE(f.ask(Predictor::kPathDensity, {8, 4}).interaction);
  EXPECT_FALSE(f.ask(Predictor::kPathDensity, {2, 7}).interaction);
  EXPECT_FALSE(f.ask(Predictor::kNone, {8, 4}).interaction);
}

TEST(Threshold, TwoLevelsWithALinger) {
  Threshold t(adaptive(Predictor::kLookahead));
  Prediction contact;
  contact.interaction = true;
  EXPECT_EQ(t.metres(), 0.8F);
  t.adapt(contact, false, 10);
  EXPECT_EQ(t.metres(), 0.3F);
  t.adapt({}, false, 25);
  EXPECT_EQ(t.metres(), 0.3F);
  t.adapt({}, false, 26);
  EXPECT_EQ(t.metres(), 0.8F);
  t.adapt({}, true, 27);
  EXPECT_EQ(t.metres(), 0.3F) << "holding a body is interaction";
}

TEST(Threshold, ContinuousFollowsTheLevel) {
  Technique technique = adaptive(Predictor::kLookahead);
  technique.law = ThresholdLaw::kContinuous;
  Threshold t(technique);
  Prediction half;
  half.interaction = true;
  half.level = 0.5F;
  t.adapt(half, false, 10);
  EXPECT_NEAR(t.metres(), 0.55F, 1e-6);
  t.adapt({}, false, 100);
  EXPECT_NEAR(t.metres(), 0.8F, 1e-6);
}

}  // namespace
}  // namespace padr::sync
