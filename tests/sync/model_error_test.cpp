#include "common/reckoning/model_error.h"

#include <gtest/gtest.h>

#include "common/reckoning/aim.h"

namespace padr::sync {
namespace {

constexpr float kThreshold = 0.3F;

/// After one more tick with this error, m and m/s.
bool exceeds(ModelError& e, Vec2 position, Vec2 velocity) {
  e.add(position, velocity);
  return e.exceeds(kThreshold);
}

TEST(ModelError, ExceedsTheThresholdNowOrWithinATick) {
  ModelError e(0);
  EXPECT_FALSE(exceeds(e, {0.3F, 0}, {}));
  EXPECT_TRUE(exceeds(e, {0.301F, 0}, {}));
  EXPECT_FALSE(exceeds(e, {0.2F, 0}, {5.9F, 0})) << "0.298 m a tick from now";
  EXPECT_TRUE(exceeds(e, {0.2F, 0}, {6.1F, 0}));
  EXPECT_FALSE(exceeds(e, {0.29F, 0}, {-6, 0})) << "it is passing";
}

TEST(ModelError, ASmallErrorCountsWithItsDuration) {
  ModelError e(0.04F);  // 0.012 m s at this threshold: 0.085 m for 9 ticks
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, {0.085F, 0}, {})) << tick;
  EXPECT_TRUE(exceeds(e, {0.085F, 0}, {}));
  e.corrected();
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, {0, 0.085F}, {})) << tick;
  EXPECT_TRUE(exceeds(e, {0.085F, 0}, {}));
}

TEST(ModelError, BelowBox2dsSlopTheAreaStartsAnew) {
  ModelError e(0.04F);
  for (int tick = 1; tick <= 6; ++tick) exceeds(e, {0.085F, 0}, {});
  EXPECT_FALSE(exceeds(e, {0.004F, 0}, {}));
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, {0.085F, 0}, {})) << tick;
}

TEST(ModelError, OffNothingLastsTooLong) {
  ModelError e(0);
  for (int tick = 1; tick <= 10'000; ++tick) ASSERT_FALSE(exceeds(e, {0.29F, 0}, {}));
}

TEST(Aim, LiesAheadOfAMovingTargetAndOnOneThatStands) {
  Aim aim(0.1F);
  aim.follow({1, 1});
  EXPECT_EQ(aim.ahead(), (Vec2{1, 1})) << "nothing is known of its motion yet";
  for (int tick = 1; tick <= 6; ++tick) aim.follow({1 + 0.05F * static_cast<float>(tick), 1});  // 3 m/s
  EXPECT_NEAR(aim.ahead().x, 1.3F + 0.3F, 1e-5F);
  EXPECT_EQ(aim.ahead().y, 1);
  for (int tick = 0; tick < 3; ++tick) aim.follow({1.3F, 1});
  EXPECT_EQ(aim.ahead(), (Vec2{1.3F, 1}));
}

TEST(Aim, WithoutLeadTheTargetIsToldAsItIs) {
  Aim aim(0);
  for (int tick = 0; tick < 9; ++tick) aim.follow({0.1F * static_cast<float>(tick), 2});
  EXPECT_EQ(aim.ahead(), (Vec2{0.8F, 2}));
}

}  // namespace
}  // namespace padr::sync
