#include "common/sync/validation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/world/test_scene.h"

namespace padr::sync {
namespace {

StatePacket good() {
  StatePacket p;
  p.seq = 1;
  p.mark_tick = 100;
  p.mark_count = 2;
  Bundle b;
  b.index = 0;
  b.tick = 90;
  b.avatar = AvatarUpdate{};
  b.avatar->position = {5, 4};
  BodyUpdate u;
  u.body = 3;
  u.has_state = true;
  u.epoch = 1;
  u.claimed = 80;
  u.state.position = {2, 2};
  b.bodies.push_back(u);
  p.updates.push_back(b);
  b.index = 1;
  b.tick = 95;
  p.updates.push_back(b);
  return p;
}

struct Spoilt {
  const char* what;
  DropReason why;
  std::function<void(StatePacket&)> spoil;
};

TEST(Admit, TheScenarioMaySetLowerLimits) {
  Scene scene;
  scene.upper = {20, 15};
  BodyState s;
  s.position = {5, 5};
  s.velocity = {30, 0};
  s.spin = 50;
  EXPECT_TRUE(believable(s, scene));
  scene.max_speed = 30;
  scene.max_spin = 50;
  EXPECT_TRUE(believable(s, scene)) << "at the limit";
  scene.max_speed = 29;
  EXPECT_FALSE(believable(s, scene));
  scene.max_speed = 30;
  scene.max_spin = 49;
  EXPECT_FALSE(believable(s, scene));
}

// No lie about epochs that a peer could have fallen for.
TEST(Admit, NoEpochFarAboveWhatIsAgreed) {
  FoldState agreed;
  agreed.authority.resize(1);
  agreed.authority[0].epoch = 5;
  Bundle b;
  b.bodies.emplace_back();
  b.bodies[0].has_state = true;
  b.bodies[0].epoch = 5 + (1U << 20U);
  EXPECT_EQ(admit_claims(b, agreed), DropReason::kNone);
  ++b.bodies[0].epoch;
  EXPECT_EQ(admit_claims(b, agreed), DropReason::kValue);
}

// The plane of a crowd has no end.
TEST(Admit, TargetsInARegionCountFromItsMiddle) {
  Scene scene = test::busy_scene(1, 10);
  const auto why = [&scene](Model model, Vec2 control) {
    Bundle b;
    b.avatar.emplace().position = (scene.lower + scene.upper) * 0.5F;
    b.avatar->model = model;
    b.avatar->control = control;
    return admit(b, scene, 4);
  };
  EXPECT_EQ(why(Model::kInput, {0, -1e4F}), DropReason::kNone);
  EXPECT_EQ(why(Model::kInput, {10'001, 0}), DropReason::kValue);
  scene.region.emplace();
  scene.lower = {20'000, 0};
  scene.upper = {20'024, 24};
  EXPECT_EQ(why(Model::kInput, {20'012, 12}), DropReason::kNone);
  EXPECT_EQ(why(Model::kInput, {30'012, 12}), DropReason::kNone);
  EXPECT_EQ(why(Model::kInput, {30'013, 12}), DropReason::kValue);
  EXPECT_EQ(why(Model::kInput, {0, 0}), DropReason::kValue);
  EXPECT_EQ(why(Model::kSecond, {10'000, 0}), DropReason::kNone) << "an acceleration is one everywhere";
  EXPECT_EQ(why(Model::kSecond, {20'012, 12}), DropReason::kValue);
}

TEST(Admit, ATargetIsBroughtToWhereItIsBelieved) {
  constexpr float kInf = std::numeric_limits<float>::max();
  Scene scene = test::busy_scene(1, 10);
  EXPECT_EQ(believable_target({8'999, -3}, scene), (Vec2{8'999, -3}));
  for (const Vec2 far : {Vec2{20'000, 0}, Vec2{-1e30F, 5}, Vec2{kInf, -kInf}}) {
    const Vec2 near = believable_target(far, scene);
    EXPECT_TRUE(believable_control(Model::kInput, near, scene));
    EXPECT_GT(length(near), 8'990) << "in the same direction";
    EXPECT_EQ(near.x > 0, far.x > 0);
  }
  scene.region.emplace();
  scene.lower = {20'000, 0};
  scene.upper = {20'024, 24};
  EXPECT_EQ(believable_target({20'100, 5}, scene), (Vec2{20'100, 5}));
  EXPECT_TRUE(believable_control(Model::kInput, believable_target({0, 0}, scene), scene));
}

TEST(Admit, Table) {
  const Scene scene = test::busy_scene(1, 10);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const auto state = [](StatePacket& p) -> BodyState& { return p.updates[0].bodies[0].state; };
  const std::vector<Spoilt> rows{
      {"nothing wrong", DropReason::kNone, [](StatePacket&) {}},
      {"two seconds ahead", DropReason::kNone, [](StatePacket& p) { p.mark_tick = 220; }},
      {"more than that", DropReason::kTick, [](StatePacket& p) { p.mark_tick = 221; }},
      {"ticks against numbers", DropReason::kOrder, [](StatePacket& p) { p.updates[1].tick = 90; }},
      {"numbers twice", DropReason::kOrder, [](StatePacket& p) { p.updates[1].index = 0; }},
      {"number beyond the mark", DropReason::kOrder, [](StatePacket& p) { p.mark_count = 1; }},
      {"last body", DropReason::kNone, [](StatePacket& p) { p.updates[0].bodies[0].body = 9; }},
      {"no such body", DropReason::kEntity, [](StatePacket& p) { p.updates[0].bodies[0].body = 10; }},
      {"NaN position", DropReason::kValue, [&](StatePacket& p) { state(p).position.x = kNan; }},
      {"infinite velocity", DropReason::kValue, [&](StatePacket& p) { state(p).velocity.y = kInf; }},
      {"NaN angle", DropReason::kValue, [&](StatePacket& p) { state(p).angle = kNan; }},
      {"far outside", DropReason::kValue, [&](StatePacket& p) { state(p).position.x = 31; }},
      {"within the margin", DropReason::kNone, [&](StatePacket& p) { state(p).position.x = 29; }},
      {"as fast as physics lets anything be, and its rounding", DropReason::kNone,
       [&](StatePacket& p) {
         state(p).velocity = {120.0001F, 0};
       }},
      {"too fast", DropReason::kValue,
       [&](StatePacket& p) {
         state(p).velocity = {121.1F, 0};
       }},
      {"spinning too fast", DropReason::kValue, [&](StatePacket& p) { state(p).spin = -96; }},
      {"epoch 0", DropReason::kValue, [](StatePacket& p) { p.updates[0].bodies[0].epoch = 0; }},
      {"epoch at the maximum", DropReason::kValue, [](StatePacket& p) { p.updates[0].bodies[0].epoch = 0xFFFFFFFFU; }},
      {"claimed in the future", DropReason::kValue, [](StatePacket& p) { p.updates[0].bodies[0].claimed = 91; }},
      {"avatar NaN", DropReason::kValue, [](StatePacket& p) { p.updates[1].avatar->velocity.x = kNan; }},
      {"target infinite", DropReason::kValue, [](StatePacket& p) { p.updates[1].avatar->control.x = kInf; }},
      {"at rest but moving", DropReason::kValue,
       [](StatePacket& p) {
         p.updates[1].avatar->awake = false;
         p.updates[1].avatar->velocity.x = 1;
       }},
  };
  for (const Spoilt& r : rows) {
    StatePacket p = good();
    r.spoil(p);
    EXPECT_EQ(admit(p, scene, 4, 100), r.why) << r.what;
  }
}

}  // namespace
}  // namespace padr::sync
