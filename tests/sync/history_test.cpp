#include "common/sync/history.h"

#include <gtest/gtest.h>

#include <set>

namespace padr::sync {
namespace {

void put(History& h, Tick t) {
  h.place(t).tick = t;
}

TEST(History, HasWhatWasPutUntilItIsForgotten) {
  History h;
  EXPECT_FALSE(h.has(0));
  h.resize(8);
  for (Tick t = 0; t < 5; ++t) put(h, t);
  for (Tick t = 0; t < 5; ++t) EXPECT_EQ(h.at(t).tick, t);
  EXPECT_FALSE(h.has(5));
  EXPECT_FALSE(h.has(-1));
  h.forget_before(3);
  for (Tick t = 0; t < 5; ++t) EXPECT_EQ(h.has(t), t >= 3) << t;
  h.resize(0);
  EXPECT_TRUE(h.empty());
  EXPECT_FALSE(h.has(4));
}

TEST(History, TheOldestMakeRoomWhereNoneIsForgotten) {
  History h;
  h.resize(4);
  for (Tick t = 0; t < 10; ++t) put(h, t);
  for (Tick t = 0; t < 10; ++t) EXPECT_EQ(h.has(t), t >= 6) << t;
}

// What is used again and again is no more than what is needed at once.
TEST(History, TheMemoryOfWhatIsForgottenIsUsedNext) {
  History h;
  h.resize(512);
  std::set<const FoldState*> used;
  for (Tick t = 0; t < 2000; ++t) {
    put(h, t);
    used.insert(&h.at(t));
    h.forget_before(t - 9);
  }
  EXPECT_LE(used.size(), 16U);
  EXPECT_TRUE(h.has(1990));
  EXPECT_FALSE(h.has(1989));
}

TEST(History, WhatIsReservedIsLikeTheOneThatIsThere) {
  History h;
  h.resize(20);
  put(h, 0);
  h.at(0).authority.resize(7);
  h.reserve(64);  // more than may be kept
  for (Tick t = 1; t < 50; ++t) {
    EXPECT_EQ(h.place(t).authority.size(), 7U) << t;
    put(h, t);
  }
}

// After an outage: more than ever at once, then a leap, over more than there is room for.
TEST(History, LeapsForgetAllThatIsBelow) {
  History h;
  h.resize(64);
  for (Tick t = 0; t < 64; ++t) put(h, t);
  h.forget_before(60);
  for (Tick t = 0; t < 64; ++t) EXPECT_EQ(h.has(t), t >= 60) << t;
  put(h, 1000);
  h.forget_before(1000);
  for (Tick t = 0; t <= 1000; ++t) EXPECT_EQ(h.has(t), t == 1000) << t;
  for (Tick t = 1001; t < 1064; ++t) put(h, t);
  EXPECT_TRUE(h.has(1000));
}

}  // namespace
}  // namespace padr::sync
