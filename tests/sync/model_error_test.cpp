#include "common/reckoning/model_error.h"

#include <gtest/gtest.h>

#include "common/reckoning/aim.h"

namespace padr::sync {
namespace {

constexpr float kThreshold = 0.3F;

/// After one more tick with this error, m, and what it will be, m.
bool exceeds(ModelError& e, float now, float ahead) {
  e.add(now, ahead);
  return e.exceeds(kThreshold);
}
/// The same of an error that is taken as it is.
bool exceeds(ModelError& e, float now) {
  e.add(now);
  return e.exceeds(kThreshold);
}

TEST(ModelError, ExceedsTheThresholdNowOrWhenItIsFourTimesAsLargeSoon) {
  ModelError e(0);
  EXPECT_FALSE(exceeds(e, 0.3F, 0.3F));
  EXPECT_TRUE(exceeds(e, 0.301F, 0.3F));
  EXPECT_FALSE(exceeds(e, 0.01F, 1.2F));
  EXPECT_TRUE(exceeds(e, 0.01F, 1.21F)) << "hardly begun, but it grows";
  EXPECT_FALSE(exceeds(e, 0.29F, 0)) << "it is passing";
}

TEST(ModelError, OfAnErrorTakenAsItIsNothingIsForeseen) {
  ModelError e(0);
  EXPECT_FALSE(exceeds(e, 0.3F));
  EXPECT_TRUE(exceeds(e, 0.301F));
}

TEST(ModelError, ASmallErrorCountsWithItsDuration) {
  ModelError e(0.04F);  // 0.012 m s at this threshold: 0.085 m for 9 ticks
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, 0.085F)) << tick;
  EXPECT_TRUE(exceeds(e, 0.085F));
  e.corrected();
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, 0.085F)) << tick;
  EXPECT_TRUE(exceeds(e, 0.085F));
}

TEST(ModelError, AnErrorToComeCountsWithItsDurationToo) {
  ModelError e(0.04F);
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, 0.01F, 4 * 0.085F)) << tick;
  EXPECT_TRUE(exceeds(e, 0.01F, 4 * 0.085F));
}

TEST(ModelError, BelowBox2dsSlopTheAreaStartsAnew) {
  ModelError e(0.04F);
  for (int tick = 1; tick <= 6; ++tick) exceeds(e, 0.085F);
  EXPECT_FALSE(exceeds(e, 0.004F));
  for (int tick = 1; tick <= 8; ++tick) EXPECT_FALSE(exceeds(e, 0.085F)) << tick;
}

TEST(ModelError, OffNothingLastsTooLong) {
  ModelError e(0);
  for (int tick = 1; tick <= 10'000; ++tick) ASSERT_FALSE(exceeds(e, 0.29F));
}

TEST(Aim, LiesAheadOfAMovingTargetAndOnOneThatStands) {
  Aim aim(0.1F);
  aim.follow({1, 1});
  EXPECT_EQ(aim.ahead(0), (Vec2{1, 1})) << "nothing is known of its motion yet";
  for (int tick = 1; tick <= 6; ++tick) aim.follow({1 + 0.05F * static_cast<float>(tick), 1});  // 3 m/s
  EXPECT_NEAR(aim.ahead(0).x, 1.3F + 0.3F, 1e-5F);
  EXPECT_EQ(aim.ahead(0).y, 1);
  EXPECT_NEAR(aim.ahead(15).x, 1.3F + 0.6F, 1e-5F) << "twice as far for those who are a quarter of a second away";
  aim.follow({1.3F, 1});
  EXPECT_EQ(aim.ahead(15), (Vec2{1.3F, 1}));
}

TEST(Aim, WithoutLeadTheTargetIsToldAsItIs) {
  Aim aim(0);
  for (int tick = 0; tick < 9; ++tick) aim.follow({0.1F * static_cast<float>(tick), 2});
  EXPECT_EQ(aim.ahead(30), (Vec2{0.8F, 2}));
}

}  // namespace
}  // namespace padr::sync
