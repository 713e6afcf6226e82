#include "common/trace/flips.h"

#include <gtest/gtest.h>

namespace padr::trace {
namespace {

constexpr PeerId kA = 0;
constexpr PeerId kB = 1;
constexpr PeerId kC = 2;
constexpr Tick kSecond = FlipMeter::kFlipTicks;

TEST(Flips, ClaimingWhatNobodyOwnsTakesItFromNobody) {
  FlipMeter m(1);
  m.owners(0, {kNoPeer});
  m.owners(1, {kA});
  m.owners(2, {kNoPeer});  // at rest
  m.owners(3, {kB});
  EXPECT_EQ(m.all(), (HandOvers{0, 0}));
  EXPECT_TRUE(m.by_body().empty());
}

TEST(Flips, ATakeoverIsAFlipWithinASecondOfTheLastChange) {
  for (const bool soon : {true, false}) {
    FlipMeter m(1);
    m.owners(10, {kA});
    m.owners(10 + kSecond - (soon ? 1 : 0), {kB});
    EXPECT_EQ(m.all(), (HandOvers{1, soon ? 1U : 0U}));
  }
}

TEST(Flips, AFlipMayGoToAThird) {
  FlipMeter m(1);
  m.owners(0, {kA});
  m.owners(100, {kB});
  m.owners(110, {kC});
  m.owners(120, {kA});
  EXPECT_EQ(m.all(), (HandOvers{3, 2}));
}

TEST(Flips, BodiesAreCountedApartAndAvatarsNotAtAll) {
  FlipMeter m(2);
  m.owners(0, {kA, kB, kA, kB});  // two bodies, two avatars
  m.owners(5, {kB, kB, kB, kA});
  m.owners(9, {kA, kB, kA, kB});
  m.owners(200, {kA, kA, kA, kB});
  EXPECT_EQ(m.all(), (HandOvers{3, 2}));
  ASSERT_EQ(m.by_body().size(), 2U);
  EXPECT_EQ(m.by_body().at(0), (HandOvers{2, 2}));
  EXPECT_EQ(m.by_body().at(1), (HandOvers{1, 0}));
}

TEST(Flips, TheSameOwnerForLongIsNoChange) {
  FlipMeter m(1);
  for (Tick t = 0; t < 1000; ++t) m.owners(t, {kA});
  m.owners(1000, {kB});
  EXPECT_EQ(m.all(), (HandOvers{1, 0}));
}

}  // namespace
}  // namespace padr::trace
