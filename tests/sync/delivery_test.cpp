#include "common/delivery/delivery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <set>
#include <utility>

#include "common/model/rng.h"
#include "tests/seed.h"

namespace padr::sync {
namespace {

std::size_t forty(const Bundle&) {
  return 40;
}

/// One link to script: what we have said so far and when.
struct Script {
  OutLink link;
  Ring<Bundle> own;
  std::size_t bytes = 1;  ///< of each datagram
  void update(Tick t) {
    Bundle b;
    b.index = static_cast<std::uint32_t>(own.size());
    b.tick = t;
    own.push_back(b);
  }
  std::optional<StatePacket> at(Tick t, bool gap = false, std::size_t room = 1000) {
    const StatePacket* p = send({t, 0, 0, gap}, room);
    return p == nullptr ? std::nullopt : std::optional(*p);
  }
  /// What goes out, if anything does; on a link wide enough for all of it.
  const StatePacket* send(const OutLink::Context& c, std::size_t room = 1000) {
    const StatePacket* p = link.compose(c, own, 0, forty, room);
    if (p != nullptr) link.left(bytes, c.now);
    return p;
  }
  /// Whether the first update goes out then, after another one if `news`.
  bool tells_first(Tick t, bool news) {
    if (news) update(t);
    const auto p = at(t, false, 100'000);
    return p && !p->updates.empty() && p->updates.front().index == 0;
  }
  void loses(std::uint32_t per_cent) {
    StatePacket p;
    p.seq = 1;
    p.loss = per_cent;
    link.on_packet(p, 0);
  }
  /// What has been sent by then has arrived, and the word of that here.
  void answers(Tick t) {
    if (t % 10 != 0) return;
    StatePacket p;
    p.seq = ++answers_;
    p.updates.resize(1);
    p.have = link.acked();
    p.seen_seq = link.sent();
    link.on_packet(p, t);
  }
  std::uint32_t answers_ = 1000;
  void hear(Tick t, std::uint32_t seq, std::uint32_t have, std::uint32_t seen, std::uint32_t age = 0,
            std::uint32_t beyond = 0) {
    StatePacket p;
    p.seq = seq + 1;
    p.mark_tick = t;
    p.updates.resize(1);  // marks alone tell of loss
    p.have = have;
    p.seen_seq = seen;
    p.seen_age = age;
    p.have_beyond = beyond;
    link.on_packet(p, t);
  }
  /// What goes out next is answered so long after it left.
  void answered_after(Tick ticks, Tick& t) {
    while (!at(t)) ++t;
    const std::uint32_t seq = link.sent();
    t += ticks;
    hear(t, seq, link.acked(), seq);
  }
};

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

TEST(Delivery, NothingToSayIsAMarkFourTimesASecond) {
  Script s;
  ASSERT_TRUE(s.at(0));
  for (Tick t = 1; t < 15; ++t) EXPECT_FALSE(s.at(t)) << t;
  const auto mark = s.at(15);
  ASSERT_TRUE(mark);
  EXPECT_TRUE(mark->updates.empty());
  EXPECT_EQ(mark->mark_tick, 15);
  EXPECT_EQ(mark->seq, 2U);
}

// Where a queue is waited for that may be none, answers to marks show it.
TEST(Delivery, WhatWaitsForAQueueDoesNotHoldMarksBack) {
  Script s;
  ASSERT_TRUE(s.at(0));
  // Its answers show a queue that drains at 1,000 bytes a second; then comes more than a second's worth.
  Tick t = 1;
  for (int i = 0; i < 40; ++i, t += 6) {
    s.link.rate().sent(200, t);
    s.link.rate().arrived(0, t + 12 * (i + 1) - 6 * i, t, 12);
  }
  s.link.rate().sent(1500, t);
  s.update(t);
  int marks = 0;
  for (const Tick until = t + kTicksPerSecond; t < until; ++t)
    if (const auto p = s.at(t)) {
      EXPECT_TRUE(p->updates.empty()) << "tick " << t;
      EXPECT_EQ(p->mark_count, 1U);
      ++marks;
    }
  EXPECT_GT(marks, 0);
}

TEST(Delivery, OnACalmLinkThreeMarksInFourCanBeSaved) {
  Script s;
  const auto calm = [&s](Tick t) { return s.send({t, 0, 0, false, true}) != nullptr; };
  ASSERT_TRUE(calm(0));
  for (Tick t = 1; t < 45; ++t) EXPECT_FALSE(calm(t)) << t;
  EXPECT_TRUE(calm(45));
  s.loses(2);
  EXPECT_FALSE(calm(59));
  EXPECT_TRUE(calm(60)) << "what the other end has heard to be lost ends the calm";
}

TEST(Delivery, WhereNothingHappensMarksAreFewerUntilSomethingDoes) {
  Script s;
  bool quiet = true;
  const auto at = [&](Tick t) { return s.send({t, 0, 0, false, false, quiet}) != nullptr; };
  s.loses(4);
  ASSERT_TRUE(at(0));
  for (Tick t = 1; t < 36; ++t) EXPECT_FALSE(at(t)) << t;
  EXPECT_TRUE(at(36));
  s.hear(40, 1, 0, 2);
  EXPECT_FALSE(at(56));
  quiet = false;
  EXPECT_TRUE(at(57)) << "news from elsewhere, and the last mark is long ago";
  quiet = true;
  s.update(58);
  EXPECT_TRUE(at(58));
  for (Tick t = 59; t < 73; ++t) EXPECT_FALSE(at(t)) << t;
  EXPECT_TRUE(at(73)) << "not acknowledged yet";
  s.hear(74, 3, 1, 4);
  EXPECT_FALSE(at(107));
  EXPECT_TRUE(at(108)) << "in this peer's phase";
}

TEST(Delivery, WhoIsSentSomethingAgainAnswersSoon) {
  Script s;
  const auto at = [&s](Tick t, bool again) { return s.send({t, 0, 0, false, true, true, 0, again}) != nullptr; };
  ASSERT_TRUE(at(0, false));
  EXPECT_FALSE(at(1, true)) << "the answer may have crossed it";
  EXPECT_FALSE(at(2, true));
  EXPECT_TRUE(at(3, true));
  for (Tick t = 4; t < 45; ++t) EXPECT_FALSE(at(t, false)) << t;
}

TEST(Delivery, ALinkThatFallsSilentIsProbedFasterAndFasterAndThenLess) {
  Script s;
  std::vector<Tick> sent;
  for (Tick t = 0; t <= 600; ++t)
    if (s.send({t, 0, 0, false, true, true}) != nullptr) sent.push_back(t);
  const auto between = [&sent](Tick from, Tick to) {
    return std::count_if(sent.begin(), sent.end(), [from, to](Tick t) { return t > from && t <= to; });
  };
  EXPECT_EQ(between(0, 89), 1) << "as calm as ever: an answer may take a mark of ours and then one of the other end";
  EXPECT_GE(between(0, 180), 35) << "so many must get lost in a row before it counts as silent";
  EXPECT_EQ(between(360, 600), 16) << "bounded, however long it lasts";
  s.hear(601, 1, 0, s.link.sent());
  EXPECT_FALSE(s.send({602, 0, 0, false, true, true}) != nullptr) << "calm again";
}

TEST(Delivery, WhereAcknowledgementsAreUrgentASilentLinkIsProbedAfterOneSecond) {
  Script s;
  std::vector<Tick> sent;
  for (Tick t = 0; t < 90; ++t)
    if (s.send({t, 0, 0, false}) != nullptr) sent.push_back(t);
  const auto after = [&sent](Tick from) {
    return std::count_if(sent.begin(), sent.end(), [from](Tick t) { return t >= from; });
  };
  EXPECT_EQ(after(0) - after(60), 4) << "every 15 ticks";
  EXPECT_EQ(after(60), 3) << "every 10 ticks";
}

/// One end of a link between two.
struct End : Script {
  std::uint32_t have = 0;                           ///< of the other end's updates
  std::deque<std::pair<Tick, StatePacket>> coming;  ///< and when
  int marks = 0;
  void turn(Tick t, bool tells, End& other) {
    for (; !coming.empty() && coming.front().first <= t; coming.pop_front()) {
      const StatePacket& p = coming.front().second;
      for (const Bundle& b : p.updates) have = std::max(have, b.index + 1);
      link.on_packet(p, t);
    }
    if (tells) update(t);
    const StatePacket* p = send({t, have, 0, false, true, false});
    if (p == nullptr) return;
    marks += p->updates.empty() ? 1 : 0;
    other.coming.emplace_back(t + 6, *p);
  }
};

// An update puts off the next mark, so an answer may take a mark of either end. Once, that counted as silence: marks
// came faster, what had arrived was taken for lost and sent again, and the other end answered that.
TEST(Delivery, WhereNothingGetsLostNothingIsSentAgainHoweverUpdatesFall) {
  End a;
  End b;
  Rng rng(test::seed(7));
  for (Tick t = 0; t < 60'000; ++t) {
    a.turn(t, rng.below(60) == 0, b);
    b.turn(t, rng.below(60) == 0, a);
  }
  EXPECT_EQ(a.link.repeats() + b.link.repeats(), 0U);
  // Of pauses between updates, a share of exp(-45/60) lasts longer than 45 ticks.
  EXPECT_LT(a.marks, 1'000 * 1.1 * 0.47 / (1 - 0.47));
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

// The other end goes on speaking and does not know of our last mark: it waits for it, perhaps for an answer.
TEST(Delivery, AMarkThatGotLostIsSentAgainWhenTheOtherEndSpeaks) {
  Script s;
  const auto at = [&s](Tick t) { return s.send({t, 0, 0, false, true, true}) != nullptr; };
  ASSERT_TRUE(at(0));
  s.hear(4, 1, 0, 1);
  for (Tick t = 1; t < 45; ++t) EXPECT_FALSE(at(t)) << t;
  ASSERT_TRUE(at(45));  // lost
  s.hear(50, 2, 0, 1);
  EXPECT_FALSE(at(50)) << "it may be on its way";
  s.hear(59, 3, 0, 1);
  EXPECT_TRUE(at(59));
  EXPECT_FALSE(at(60));
}

// Or else all who begin together would send their first marks, to everybody, in the same tick.
TEST(Delivery, MarksComeInThePeersPhaseFromTheFirstOn) {
  for (const Tick phase : {0, 11, 22, 44}) {
    Script s;
    std::vector<Tick> sent;
    for (Tick t = 0; t <= 300; ++t) {
      if (s.send({t, 0, 0, false, true, false, phase}) != nullptr) sent.push_back(t);
      s.answers(t);
    }
    ASSERT_GE(sent.size(), 6U);
    EXPECT_LT(sent.front(), 45);
    for (const Tick t : sent) EXPECT_EQ((t + phase) % 45, 0) << t;
  }
}

// Each a little early: a whole mark more after each update would be a third more of all marks where updates are rare.
TEST(Delivery, AfterAnUpdateMarksGetIntoPhaseAgainBitByBit) {
  Script s;
  std::vector<Tick> sent;
  for (Tick t = 0; t <= 900; ++t) {
    if (t == 100) s.update(t);
    if (s.send({t, 0, 0, false, true, false, 11}) != nullptr) sent.push_back(t);
    if (t == 110) s.hear(t, 1, 1, s.link.sent());
    s.answers(t);
  }
  const auto update = std::find(sent.begin(), sent.end(), 100);
  ASSERT_GE(sent.end() - update, 14);
  for (auto t = update + 1; t != sent.end(); ++t) {
    EXPECT_GE(*t - *(t - 1), 40) << *t;
    EXPECT_LE(*t - *(t - 1), 45) << *t;
  }
  for (auto t = update + 10; t != sent.end(); ++t) EXPECT_EQ((*t + 11) % 45, 0) << *t;
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

TEST(Delivery, WhereMarksGetLostTheyAreNotSaved) {
  Script s;
  s.loses(5);
  const auto at = [&s](Tick t) { return s.send({t, 0, 0, false, false, true}) != nullptr; };
  ASSERT_TRUE(at(0));
  EXPECT_FALSE(at(14));
  EXPECT_TRUE(at(15));
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

TEST(Delivery, AMissingUpdateIsAskedForAfterShortPatience) {
  Script s;
  s.at(0);
  EXPECT_FALSE(s.at(1, true));
  EXPECT_FALSE(s.at(2, true));
  EXPECT_FALSE(s.at(3, true));
  EXPECT_TRUE(s.at(4, true));
  EXPECT_FALSE(s.at(5, true));
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

/// Two ends that have nothing to tell one another, and what a network in bursts leaves of their marks.
struct BurstyLink {
  explicit BurstyLink(std::uint64_t seed) : rng(seed) {}
  struct End {
    OutLink link;
    Ring<Bundle> own;
    bool bad = false;                                  ///< its way out loses everything
    std::deque<std::pair<Tick, StatePacket>> arrives;  ///< here
    std::uint32_t seen = 0;
    Tick answered = 0;
    std::uint64_t sent = 0;
  };
  std::array<End, 2> ends;
  Rng rng;
  int silences = 0;  ///< of 3 s, at either end
  void tick(Tick t) {
    for (std::size_t i = 0; i < 2; ++i) {
      End& e = ends[i];
      for (; !e.arrives.empty() && e.arrives.front().first <= t; e.arrives.pop_front()) {
        const StatePacket& p = e.arrives.front().second;
        if (p.seen_seq > e.seen) e.seen = p.seen_seq, e.answered = t;
        e.link.on_packet(p, t);
      }
      if (t - e.answered == 180) ++silences;
      const StatePacket* p =
          e.link.compose({t, 0, 0, false, true, true, static_cast<Tick>(11 * i)}, e.own, 0, forty, 1000);
      if (p == nullptr) continue;
      e.link.left(60, t);
      ++e.sent;
      e.bad = e.bad ? !rng.chance(0.3) : rng.chance(0.01);  // gemodel 1% 30%
      if (!e.bad) ends[1 - i].arrives.emplace_back(t + 5, *p);
    }
  }
};

// In a burst one datagram after the other gets lost, however far apart they are: at a calm link's pace five of them are
// more than the 3 s after which a peer counts as silent.
TEST(Delivery, ABurstOfLossesDoesNotSilenceACalmLink) {
  BurstyLink link(test::seed(7));
  constexpr Tick kTenHours = 10 * 3600 * 60;
  for (Tick t = 0; t < kTenHours; ++t) link.tick(t);
  EXPECT_LE(link.silences, 2) << "in ten hours";
  const double a_second = static_cast<double>(link.ends[0].sent) * 60 / kTenHours;
  EXPECT_LT(a_second, 1.6) << "a calm link stays one";
}

}  // namespace
}  // namespace padr::sync
