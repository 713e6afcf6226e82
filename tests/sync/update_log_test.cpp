#include "common/sync/update_log.h"

#include <gtest/gtest.h>

#include <limits>

namespace padr::sync {
namespace {

Bundle bundle(PeerId peer, std::uint32_t index, Tick tick) {
  Bundle b;
  b.peer = peer;
  b.index = index;
  b.tick = tick;
  return b;
}

/// The log of slots whose peers are there from tick 0 on.
UpdateLog of_members(int slots) {
  UpdateLog log(slots);
  for (int p = 0; p < slots; ++p) log.begin(static_cast<PeerId>(p), 0, -1);
  return log;
}

TEST(UpdateLog, CompleteOnlyWhenWhatWasPromisedIsHere) {
  UpdateLog log = of_members(2);
  EXPECT_EQ(log.complete(1), -1);
  log.mark(1, 10, 0);
  EXPECT_EQ(log.complete(1), 10);
  log.mark(1, 20, 2);
  EXPECT_EQ(log.complete(1), 10);
  EXPECT_TRUE(log.insert(bundle(1, 1, 18)));
  EXPECT_EQ(log.complete(1), 10);
  EXPECT_EQ(log.have(1), 0U);
  EXPECT_EQ(log.have_beyond(1), 1U);
  EXPECT_TRUE(log.insert(bundle(1, 0, 12)));
  EXPECT_EQ(log.complete(1), 20);
  EXPECT_EQ(log.have(1), 2U);
  EXPECT_EQ(log.have_beyond(1), 0U);
}

TEST(UpdateLog, BeyondAHoleNoMoreIsKeptThanThat) {
  UpdateLog log = of_members(1);
  for (std::uint32_t i = 1; i <= UpdateLog::kMostBeyond; ++i)
    ASSERT_TRUE(log.insert(bundle(0, i, static_cast<Tick>(i)))) << i;
  EXPECT_FALSE(log.insert(bundle(0, UpdateLog::kMostBeyond + 1, 5000)));
  EXPECT_EQ(log.beyond(0), UpdateLog::kMostBeyond);
  // A million promises that are not kept are no reason to forget one that is.
  for (std::uint32_t i = 1; i < 1'000'000; ++i) log.mark(0, static_cast<Tick>(5000 + i), 10'000 + i);
  log.mark(0, 2'000'000, UpdateLog::kMostBeyond + 1);
  EXPECT_EQ(log.complete(0), -1);
  EXPECT_TRUE(log.insert(bundle(0, 0, 0)));
  EXPECT_EQ(log.complete(0), 2'000'000);
}

TEST(UpdateLog, AnOldMarkTakesNothingBack) {
  UpdateLog log = of_members(1);
  log.mark(0, 30, 0);
  log.mark(0, 20, 0);
  EXPECT_EQ(log.complete(0), 30);
}

TEST(UpdateLog, KnownUpdatesAreRefusedAndTicksComeByPeer) {
  UpdateLog log = of_members(3);
  EXPECT_TRUE(log.insert(bundle(2, 0, 5)));
  EXPECT_TRUE(log.insert(bundle(0, 0, 5)));
  EXPECT_TRUE(log.insert(bundle(1, 0, 5)));
  EXPECT_FALSE(log.insert(bundle(1, 0, 5)));
  ASSERT_EQ(log.at(5).size(), 3U);
  for (PeerId p = 0; p < 3; ++p) EXPECT_EQ(log.at(5)[p].peer, p);
  EXPECT_TRUE(log.at(6).empty());
}

TEST(UpdateLog, ASecondUpdateOfATickIsRefused) {
  UpdateLog log = of_members(1);
  EXPECT_TRUE(log.insert(bundle(0, 0, 5)));
  EXPECT_FALSE(log.insert(bundle(0, 1, 5)));
  EXPECT_EQ(log.have(0), 1U);
  EXPECT_EQ(log.at(5).size(), 1U);
}

TEST(UpdateLog, ClosedIsCompleteForEverOnceAllIsHere) {
  UpdateLog log = of_members(1);
  log.close(0, 1);
  EXPECT_EQ(log.complete(0), -1);
  log.insert(bundle(0, 0, 9));
  EXPECT_EQ(log.complete(0), std::numeric_limits<Tick>::max());
}

TEST(UpdateLog, WhatFillsAHoleBringsNothingMoreOfWhatWasHeld) {
  UpdateLog log = of_members(1);
  log.insert(bundle(0, 0, 4));
  log.insert(bundle(0, 2, 8));
  log.insert(bundle(0, 3, 10));
  log.mark(0, 9, 3);
  const std::vector<Bundle> held = log.hold(0);
  ASSERT_EQ(held.size(), 2U);
  EXPECT_TRUE(log.at(8).empty());
  EXPECT_TRUE(log.insert(bundle(0, 1, 6)));
  EXPECT_EQ(log.have(0), 2U);
  EXPECT_LT(log.complete(0), 9);
  for (const Bundle& b : held) EXPECT_TRUE(log.insert(b));
  EXPECT_EQ(log.have(0), 4U);
  EXPECT_EQ(log.complete(0), 9);
}

TEST(UpdateLog, PruningForgetsWhatIsBelow) {
  UpdateLog log = of_members(1);
  log.insert(bundle(0, 0, 4));
  log.insert(bundle(0, 1, 8));
  log.prune(8, 8);
  EXPECT_TRUE(log.at(4).empty());
  EXPECT_EQ(log.at(8).size(), 1U);
  EXPECT_EQ(log.size(), 1U);
}

TEST(UpdateLog, WhatIsFinalIsKeptForOthersButTakesNothingMore) {
  UpdateLog log = of_members(1);
  log.insert(bundle(0, 0, 4));
  log.prune(8, 3);
  EXPECT_EQ(log.at(4).size(), 1U);
  EXPECT_FALSE(log.insert(bundle(0, 1, 6)));
  EXPECT_EQ(log.of(0, 0).size(), 1U);
}

TEST(UpdateLog, WhatLiesBeyondAnEndNeverHappened) {
  UpdateLog log = of_members(1);
  for (const std::uint32_t i : {0U, 1U, 3U}) log.insert(bundle(0, i, 10 + static_cast<Tick>(i)));
  EXPECT_EQ(log.close(0, 2), 13) << "the earliest tick that has changed";
  EXPECT_TRUE(log.at(13).empty());
  EXPECT_FALSE(log.insert(bundle(0, 2, 12)));
  EXPECT_EQ(log.complete(0), std::numeric_limits<Tick>::max());
}

TEST(UpdateLog, ANewPeersNumbersGoOnWhereTheLastOnesEnded) {
  UpdateLog log = of_members(1);
  log.insert(bundle(0, 0, 5));
  log.close(0, 2);  // number 1 is still missing
  log.open(0, 20);
  EXPECT_EQ(log.complete(0), -1);
  log.insert(bundle(0, 1, 7));
  EXPECT_EQ(log.complete(0), 20) << "up to its coming nobody else speaks for the slot";
  log.insert(bundle(0, 2, 25));
  log.mark(0, 30, 3);
  EXPECT_EQ(log.complete(0), 30);
}

// Once, whoever began with the world of a member to which a liar had told an earlier end waited for such updates for
// ever, and took them for forged when they came.
TEST(UpdateLog, WhoHasConfirmedAnEndTakesNothingMoreBeforeALaterOne) {
  UpdateLog log = of_members(1);
  log.insert(bundle(0, 0, 5));
  log.close(0, 1);
  log.close(0, 3);
  log.open(0, 20);
  EXPECT_FALSE(log.insert(bundle(0, 1, 7)));
  EXPECT_EQ(log.have(0), 3U) << "where the next occupant's begin";
  EXPECT_TRUE(log.insert(bundle(0, 3, 25)));
  log.mark(0, 30, 4);
  EXPECT_EQ(log.complete(0), 30);
}

}  // namespace
}  // namespace padr::sync
