#include "tools/monitor/agreement.h"

#include <gtest/gtest.h>

namespace padr::monitor {
namespace {

using Verdict = Agreement::Verdict;

TEST(Agreement, OneAloneProvesNothing) {
  Agreement a;
  a.note(0, 30, 1);
  EXPECT_EQ(a.all(), Verdict::kUnknown);
  EXPECT_EQ(a.of(0), Verdict::kUnknown);
  a.note(1, 33, 2);
  EXPECT_EQ(a.all(), Verdict::kUnknown) << "another tick";
  a.note(1, 30, 1);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
  EXPECT_EQ(a.compared(), 1U);
  a.note(1, 30, 1);
  EXPECT_EQ(a.compared(), 1U) << "said twice, compared once";
}

TEST(Agreement, TheFewAreWrongAndMayMend) {
  Agreement a;
  for (PeerId p = 0; p < 3; ++p) a.note(p, 30, p == 0 ? 7 : 1);
  EXPECT_EQ(a.of(0), Verdict::kUnknown) << "it may be apart";
  a.settle(0, false);
  EXPECT_EQ(a.of(0), Verdict::kDiffers);
  EXPECT_EQ(a.of(1), Verdict::kIdentical);
  EXPECT_EQ(a.all(), Verdict::kDiffers);
  EXPECT_EQ(a.first_difference(), 30);
  for (PeerId p = 0; p < 3; ++p) a.note(p, 60, 2);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
  EXPECT_EQ(a.first_difference(), 30) << "it was there";
  EXPECT_EQ(a.newest(), 60);
}

TEST(Agreement, OfTwoTheLowerSlotIsHeldToBeRight) {
  Agreement a;
  a.note(3, 30, 1);
  a.note(1, 30, 2);
  a.settle(1, false);
  a.settle(3, false);
  EXPECT_EQ(a.of(1), Verdict::kIdentical);
  EXPECT_EQ(a.of(3), Verdict::kDiffers);
}

TEST(Agreement, TheVerdictOutlivesTheSession) {
  Agreement a;
  for (PeerId slot = 0; slot < 2; ++slot) a.note(slot, 60, 1);
  for (const PeerId slot : {PeerId{0}, PeerId{1}, PeerId{1}}) {
    a.forget(slot);
    EXPECT_EQ(a.all(), Verdict::kIdentical);
    EXPECT_EQ(a.of(slot), Verdict::kUnknown);
  }
  EXPECT_EQ(a.compared(), 1U);
}

TEST(Agreement, WhoIsApartMayConfirmAnotherWorld) {
  Agreement a;
  for (PeerId p = 0; p < 3; ++p) a.note(p, 30, p == 2 ? 7 : 1);
  a.settle(2, true);
  EXPECT_EQ(a.of(2), Verdict::kApart);
  EXPECT_EQ(a.all(), Verdict::kApart);
  EXPECT_EQ(a.first_difference(), std::nullopt);
  for (PeerId p = 0; p < 3; ++p) a.note(p, 33, p == 2 ? 8 : 2);
  EXPECT_EQ(a.all(), Verdict::kApart);
  a.settle(2, false);
  EXPECT_EQ(a.all(), Verdict::kDiffers);
  EXPECT_EQ(a.first_difference(), 30);
}

TEST(Agreement, AnOlderTickDoesNotOverruleANewerOne) {
  Agreement a;
  a.note(0, 60, 1);
  a.note(1, 60, 1);
  a.note(0, 30, 1);
  a.note(1, 30, 2);
  a.settle(1, false);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
  EXPECT_EQ(a.first_difference(), 30);
}

TEST(Agreement, ADifferenceThatWasMendedBeforeAnybodyToldWhyCounts) {
  Agreement a;
  a.note(0, 30, 1);
  a.note(1, 30, 2);
  a.note(0, 33, 3);
  a.note(1, 33, 3);
  a.settle(1, false);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
  EXPECT_EQ(a.first_difference(), 30);
}

TEST(Agreement, WhoWasApartAndIsBackHasNotDiffered) {
  Agreement a;
  a.note(0, 30, 1);
  a.note(1, 30, 2);
  a.settle(1, true);
  a.note(0, 33, 3);
  a.note(1, 33, 3);
  a.settle(1, false);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
  EXPECT_EQ(a.first_difference(), std::nullopt);
}

TEST(Agreement, WhoHasGoneIsForgotten) {
  Agreement a;
  a.note(0, 30, 1);
  a.note(1, 30, 2);
  a.forget(1);
  EXPECT_EQ(a.of(1), Verdict::kUnknown);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
  a.note(1, 60, 5);
  EXPECT_EQ(a.of(1), Verdict::kUnknown) << "somebody else sits there now";
}

TEST(Agreement, MemoryIsBounded) {
  Agreement a;
  for (Tick t = 1; t < 100'000; ++t) a.note(0, t, 1);
  a.note(1, 1, 2);
  EXPECT_EQ(a.all(), Verdict::kUnknown) << "too long ago";
  a.note(1, 99'999, 1);
  EXPECT_EQ(a.all(), Verdict::kIdentical);
}

}  // namespace
}  // namespace padr::monitor
