// Which updates go out, and which again.
#include "common/delivery/delivery.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

#include "tests/sync/script.h"

namespace padr::sync {
namespace {

using test::forty;
using test::Script;

// Its ticks get to when something came only when more has come.
TEST(Delivery, WhoIsAlwaysBehindTellsWhatHasComeAllTheSame) {
  constexpr Tick kBehind = 5;
  Script s;
  std::uint32_t told = 0;
  for (Tick t = 0; t < 100; ++t) {
    StatePacket p;
    p.seq = static_cast<std::uint32_t>(t + 1);
    s.link.on_packet(p, t + kBehind);
    s.update(t);
    const auto sent = s.at(t);
    ASSERT_TRUE(sent);
    if (sent->seen_seq == 0) continue;
    const Tick came = static_cast<Tick>(sent->seen_seq) - 1 + kBehind;
    EXPECT_EQ(t - static_cast<Tick>(sent->seen_age), came);
    EXPECT_LE(t - came, kBehind);
    told = sent->seen_seq;
  }
  EXPECT_GE(told, 100 - 2 * kBehind);
}

// A member may say anything: that it has had a datagram for longer than the session lasts, too.
TEST(Delivery, AnImpossibleAgeOfAnAcknowledgementIsNone) {
  Script s;
  s.update(0);
  ASSERT_TRUE(s.at(0));
  s.hear(10, 1, 0, s.link.sent(), 0x80000000U);
  s.hear(10, 2, 0, s.link.sent(), 11);
  EXPECT_EQ(s.link.unanswered(10), 10);
  s.hear(10, 3, 0, s.link.sent(), 10);
  EXPECT_EQ(s.link.unanswered(10), 0);
}

TEST(Delivery, OnALinkThatHasBeenSilentForThreeSecondsOneUpdateIsRepeatedAtATimeUntilItAnswers) {
  Script s;
  s.hear(0, 1, 0, 0);
  s.update(1);
  s.update(1);
  s.update(1);
  ASSERT_EQ(s.at(1)->updates.size(), 3U);
  std::size_t again = 0;
  for (Tick t = 2; t < 180; ++t)
    if (const auto p = s.at(t)) again += p->updates.size();
  EXPECT_GE(again, 6U);
  std::array<int, 3> times{};
  for (Tick t = 181; t < 400; ++t)
    if (const auto p = s.at(t)) {
      ASSERT_EQ(p->updates.size(), 1U) << t;
      ++times.at(p->updates.front().index);
    }
  EXPECT_GT(times[0], 3);
  for (const int n : times) EXPECT_NEAR(n, times[0], 1) << "in turn";
  s.update(400);
  EXPECT_EQ(s.at(400)->updates.back().index, 3U) << "what is new goes out: the silence may be the other way's";
  s.hear(410, 2, 0, s.link.sent());
  const auto repair = s.at(411);
  ASSERT_TRUE(repair);
  EXPECT_GE(repair->updates.size(), 2U) << "all but what went out last";
}

// Once, each update went out three times within the two seconds of an outage, and took from others what a peer may
// send.
TEST(Delivery, WhileUpdatesAreUnderWayALinkIsSilentAfterLess) {
  constexpr Tick kCut = 100;
  Script s;
  for (Tick t = 0; t < kCut; ++t) {
    if (t % 3 == 0) s.update(t);
    s.at(t);
    s.hear(t, static_cast<std::uint32_t>(t), static_cast<std::uint32_t>(s.own.size()), s.link.sent());
  }
  std::size_t again = 0;
  std::size_t most = 0;
  for (Tick t = kCut; t < kCut + 120; ++t) {
    if (t % 3 == 0) s.update(t);
    const std::uint64_t before = s.link.repeats();
    s.at(t);
    const std::size_t now = s.link.repeats() - before;
    again += now;
    if (t > kCut + 60) most = std::max(most, now);
  }
  EXPECT_EQ(most, 1U) << "one with each datagram";
  EXPECT_LT(again, 60U) << "of 40 updates";
  s.hear(kCut + 120, kCut + 120, s.link.acked(), s.link.sent());
  EXPECT_GE(s.at(kCut + 121, false, 100'000)->updates.size(), 30U) << "what is missing at once";
}

// A round trip of more than a second is no silence.
TEST(Delivery, ALongLinkIsNotSilent) {
  constexpr Tick kRoundTrip = 80;
  Script s;
  std::map<Tick, std::pair<std::uint32_t, std::uint32_t>> answers;  // by tick: what has arrived
  std::uint64_t at_first = 0;
  for (Tick t = 0; t < 1200; ++t) {
    if (t % 10 == 0) s.update(t);
    if (s.at(t)) answers[t + kRoundTrip] = {static_cast<std::uint32_t>(s.own.size()), s.link.sent()};
    if (answers.contains(t)) s.hear(t, static_cast<std::uint32_t>(t), answers[t].first, answers[t].second);
    if (t == 300) at_first = s.link.repeats();
  }
  EXPECT_EQ(s.link.repeats(), at_first);
}

// The window of a link that has not answered is full: marks alone would never tell whoever hears us, though we hear
// nothing of it, what it lacks.
TEST(Delivery, AFullWindowDoesNotKeepRepeatsFromASilentLink) {
  Script s;
  s.link.rate().begin_window();
  s.update(0);
  std::size_t again = 0;
  for (Tick t = 0; t < 600; ++t) {
    const StatePacket* p = s.link.compose({t, 0, 0, false}, s.own, 0, forty, 1000);
    if (p == nullptr) continue;
    if (t > 240) again += p->updates.size();
    s.link.left(100, t);
  }
  EXPECT_GE(again, 5U);
  EXPECT_LE(again, 6U) << "once a second";
}

TEST(Delivery, WhoHasJustComeInBeginsAtOnceAndIsToldItsFirstWordsUntilItHasSpoken) {
  Script s;
  s.link = OutLink(0);
  s.update(5);
  ASSERT_TRUE(s.tells_first(7, false));
  int times = 1;
  for (Tick t = 8; t < 24; ++t) times += s.tells_first(t, t % 3 == 0) ? 1 : 0;
  EXPECT_GE(times, 5) << "with each of the others";
  s.hear(24, 1, 1, s.link.sent());
  s.update(25);
  const auto after = s.at(25);
  ASSERT_TRUE(after);
  EXPECT_NE(after->updates.front().index, 0U);
}

TEST(Delivery, NoFirstWordIsToldWithoutEnd) {
  Script s;
  s.link = OutLink(0);
  s.update(0);
  int times = 0;
  for (Tick t = 0; t < 60; ++t) times += s.tells_first(t, true) ? 1 : 0;
  EXPECT_LE(times, 10);
}

TEST(Delivery, OnAVeryLossyLinkTheSecondCopyGoesAlone) {
  Script s;
  s.loses(15);
  s.at(0);
  s.update(2);
  ASSERT_TRUE(s.at(2));
  EXPECT_FALSE(s.at(3));
  EXPECT_FALSE(s.at(4));
  const auto copy = s.at(5);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->updates.size(), 1U);
  for (Tick t = 6; t < 15; ++t) EXPECT_FALSE(s.at(t)) << t;
  EXPECT_EQ(s.link.repeats(), 1U);
}

TEST(Delivery, OnALossyLinkAnUpdateGoesAgainWithWhateverGoesNext) {
  Script s;
  s.loses(10);
  s.at(0);
  s.update(3);
  const auto first = s.at(3);
  ASSERT_TRUE(first);
  ASSERT_EQ(first->updates.size(), 1U);
  EXPECT_EQ(first->mark_count, 1U);
  for (Tick t = 4; t < 10; ++t) EXPECT_FALSE(s.at(t)) << t;
  s.update(10);
  const auto second = s.at(10);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->updates.size(), 2U) << "the unacknowledged one goes along once";
  s.update(13);
  ASSERT_EQ(s.at(13)->updates.size(), 2U) << "but not twice";
}

TEST(Delivery, WhatIsAcknowledgedIsNotRepeated) {
  Script s;
  s.update(1);
  ASSERT_TRUE(s.at(1));
  s.hear(5, 1, 1, 1);
  EXPECT_EQ(s.link.acked(), 1U);
  s.update(6);
  EXPECT_EQ(s.at(6)->updates.size(), 1U);
  EXPECT_EQ(s.link.repeats(), 0U);
}

TEST(Delivery, WhereNothingGetsLostNothingGoesTwice) {
  Script s;
  s.loses(1);
  s.at(0);
  for (Tick t = 1; t < 12; t += 3) {
    s.update(t);
    EXPECT_EQ(s.at(t)->updates.size(), 1U) << t;
  }
}

TEST(Delivery, ALossThatShowsIsRepairedAtOnce) {
  Script s;
  s.loses(10);
  s.hear(0, 1, 0, 0);
  for (Tick t = 0; t < 60; t += 15) s.at(t);  // marks
  for (Tick t = 1; t <= 4; ++t)
    s.hear(t * 15 - 14, 1 + static_cast<std::uint32_t>(t), 0, static_cast<std::uint32_t>(t));
  s.update(60);
  ASSERT_TRUE(s.at(60));  // seq 5, lost
  s.update(62);
  ASSERT_EQ(s.at(62)->updates.size(), 2U);  // seq 6, lost too
  s.update(64);
  ASSERT_EQ(s.at(64)->updates.size(), 2U);  // seq 7 arrives, with the newest and the echo of the one before
  EXPECT_FALSE(s.at(65));
  s.hear(66, 9, 0, 7, 0, 3);
  const auto repair = s.at(66);
  ASSERT_TRUE(repair);
  ASSERT_EQ(repair->updates.size(), 1U);
  EXPECT_EQ(repair->updates[0].index, 0U);
}

TEST(Delivery, WhatDoesNotFitGoesNextAndOfThatTheOldestFirst) {
  Script s;
  for (Tick t = 0; t < 5; ++t) s.update(t);
  const auto first = s.at(5, false, 100);
  ASSERT_EQ(first->updates.size(), 2U);
  EXPECT_EQ(first->updates[0].index, 3U);
  EXPECT_EQ(first->updates[1].index, 4U);
  const auto second = s.at(6, false, 100);
  ASSERT_EQ(second->updates.size(), 2U);
  EXPECT_EQ(second->updates[0].index, 0U);
  EXPECT_EQ(second->updates[1].index, 1U);
}

// Once, the newest was always the first, and of a link with room for one the other end never got what it waited for.
TEST(Delivery, WhereOnlyWhatIsNewFitsTheOldestHasItsTurn) {
  Script s;
  std::vector<std::uint32_t> told;
  for (Tick t = 0; t < 8; ++t) {
    s.update(t);
    if (t < 4) continue;
    const auto p = s.at(t, false, 40);
    ASSERT_TRUE(p);
    ASSERT_EQ(p->updates.size(), 1U);
    told.push_back(p->updates[0].index);
  }
  EXPECT_EQ(told, (std::vector<std::uint32_t>{4, 0, 6, 1}));
}

// Far beyond the first missing update the other end cannot acknowledge one by one. Once, what it had already was
// repeated for ever, newest first, and the first missing one never got its turn.
TEST(Delivery, ManyAtOnceOnANarrowLinkAllArrive) {
  constexpr std::size_t kRoom = 6 * 40;
  constexpr std::uint32_t kUpdates = 200;
  Script s;
  for (std::uint32_t i = 0; i < kUpdates; ++i) s.update(0);
  std::set<std::uint32_t> missing;
  for (std::uint32_t i = 0; i < kUpdates; ++i) missing.insert(i);
  Tick t = 0;
  for (; !missing.empty() && t < 200; ++t) {
    if (const auto p = s.at(t, false, kRoom))
      for (const Bundle& b : p->updates) missing.erase(b.index);
    const std::uint32_t have = missing.empty() ? kUpdates : *missing.begin();
    std::uint32_t beyond = 0;
    for (std::uint32_t i = 0; i < 32; ++i)
      if (have + 1 + i < kUpdates && !missing.contains(have + 1 + i)) beyond |= 1U << i;
    s.hear(t, static_cast<std::uint32_t>(t), have, s.link.sent(), 0, beyond);
  }
  EXPECT_TRUE(missing.empty()) << missing.size() << " are missing, the first is " << *missing.begin();
  EXPECT_LT(t, 100);
}

TEST(Delivery, RoundTripLeavesTheOtherSidesWaitOut) {
  Script s;
  for (Tick t = 0; t < 60 * 20; ++t) {
    if (!s.at(t)) continue;
    const std::uint32_t seq = s.link.sent();
    s.hear(t + 12, seq, 0, seq, 5);
  }
  EXPECT_NEAR(s.link.round_trip(), 7, 0.5);
}

// Whoever has been paused for three seconds answers then, and that is no round trip of the link.
TEST(Delivery, AStandstillOfTheOtherEndPutsOffNoRepeats) {
  Script s;
  Tick t = 0;
  for (int i = 0; i < 40; ++i) s.answered_after(6, t);
  s.answered_after(170, t);
  EXPECT_NEAR(s.link.round_trip(), 6, 1);
  s.update(++t);
  ASSERT_TRUE(s.at(t)->updates.size() == 1);
  Tick again = t + 1;
  for (auto p = s.at(again); again - t < 1000 && (!p || p->updates.empty()); p = s.at(again)) ++again;
  EXPECT_LE(again - t, 40);
  for (int i = 0; i < 40; ++i) s.answered_after(170, t);
  EXPECT_GT(s.link.round_trip(), 120) << "a link that has become slow is believed";
}

// Nor is it a queue, as of a link that carries next to nothing.
TEST(Delivery, AStandstillOfTheOtherEndMakesNoLinkNarrow) {
  Script s;
  Tick t = 0;
  s.bytes = 200;
  s.answered_after(6, t);
  s.bytes = 60;
  const std::uint32_t waits = s.link.sent() + 8;
  for (const Tick end = t + 200; t < end; ++t) s.at(t);
  ASSERT_LT(waits, s.link.sent());
  s.hear(t, waits, 0, waits);
  EXPECT_FALSE(s.link.rate().is_limited()) << s.link.rate().rate() << " bytes/s";
}

TEST(Delivery, NonsenseAcknowledgementsAreHarmless) {
  Script s;
  s.update(1);
  s.at(1);
  s.hear(2, 4000000000U, 4000000000U, 4000000000U, 4000000000U);
  s.update(3);
  s.at(3);
  s.hear(4, 1, 0, 0);
  SUCCEED();
}

}  // namespace
}  // namespace padr::sync
