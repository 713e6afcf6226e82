// When a datagram without updates goes out.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <utility>

#include <set>
#include "common/model/rng.h"
#include "tests/seed.h"

#include "tests/sync/script.h"

namespace padr::sync {
namespace {

using test::forty;
using test::Script;

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
    s.link.rate().acknowledged(0);
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

// Once, a clock that was 1.8 s late after a suspension made a wide link look like one of 60 bytes a second. Marks alone
// took more, the queue never drained, and no update was sent for 8 s.
TEST(Delivery, WhereMarksMayBeAllThatALinkCarriesTheOldestUpdateGoesWithEach) {
  Script s;
  ASSERT_TRUE(s.at(0));
  Tick t = 1;
  for (int i = 0; i < 8; ++i, t += 6) {
    s.link.rate().sent(80, t);
    s.link.rate().acknowledged(0);
    s.link.rate().arrived(0, t + 120 * (i + 1), t, 12);
  }
  s.bytes = 80;
  ASSERT_LT(s.link.rate().rate(), 100);
  for (int i = 0; i < 3; ++i) s.update(t);
  std::set<std::uint32_t> told;
  for (const Tick until = t + 6 * kTicksPerSecond; t < until; ++t)
    if (const auto p = s.at(t)) {
      EXPECT_LE(p->updates.size(), 1U) << "tick " << t;
      for (const Bundle& b : p->updates) told.insert(b.index);
    }
  EXPECT_EQ(told, (std::set<std::uint32_t>{0, 1, 2}));
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

TEST(Delivery, WhereMarksGetLostTheyAreNotSaved) {
  Script s;
  s.loses(5);
  const auto at = [&s](Tick t) { return s.send({t, 0, 0, false, false, true}) != nullptr; };
  ASSERT_TRUE(at(0));
  EXPECT_FALSE(at(14));
  EXPECT_TRUE(at(15));
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
