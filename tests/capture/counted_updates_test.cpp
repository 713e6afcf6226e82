#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "tools/capture/counted_updates.h"

namespace padr::capture {
namespace {

/// A session log filled by hand: what each incarnation told.
class Session {
 public:
  Session& update(const Incarnation& by, std::uint32_t index, Tick tick) {
    bundle(by, index, tick).avatar.emplace();
    return *this;
  }
  Session& removal(const Incarnation& by, std::uint32_t index, Tick tick, const Incarnation& who, std::uint32_t count) {
    bundle(by, index, tick).removals = {{who.slot, who.incarnation, count}};
    return *this;
  }
  Session& admission(const Incarnation& by, std::uint32_t index, Tick tick, const Incarnation& who,
                     std::uint32_t first) {
    sync::Admission a;
    a.slot = who.slot;
    a.incarnation = who.incarnation;
    a.first = first;
    a.at.address[15] = 1;
    a.at.port = 1;
    a.have.assign(kSlots, 0);
    bundle(by, index, tick).admission = a;
    return *this;
  }
  Session& leave(const Incarnation& by, std::uint32_t index, Tick tick) {
    bundle(by, index, tick).leave = true;
    return *this;
  }
  Session& mark(const Incarnation& by, std::uint32_t count, Tick tick, std::int64_t heard_ns) {
    SessionLog::Voice& v = session_log.voices[by];
    v.marks[count] = tick;
    v.last_tick = tick;
    v.last_ns = heard_ns;
    return *this;
  }
  CountedUpdates counted(int peers) const {
    CountedUpdates c(session_log, scene, kSlots);
    c.begin(peers);
    return c;
  }

  static constexpr int kSlots = 4;
  SessionLog session_log;
  Scene scene = scenarios::load_embedded("arena", 1);

 private:
  sync::Bundle& bundle(const Incarnation& by, std::uint32_t index, Tick tick) {
    sync::Bundle& b = session_log.voices[by].updates[index];
    b.peer = by.slot;
    b.index = index;
    b.tick = tick;
    return b;
  }
};

std::vector<PeerId> who(const CountedUpdates& c, Tick tick) {
  std::vector<PeerId> slots;
  for (const sync::Bundle& b : c.at(tick)) slots.push_back(b.peer);
  return slots;
}

TEST(CountedUpdates, AMarkThatIsFulfilledMakesALifeComplete) {
  Session s;
  s.update({0, 0}, 0, 5).update({0, 0}, 2, 9).mark({0, 0}, 1, 7, 1).mark({0, 0}, 3, 12, 2);
  bool missing = false;
  EXPECT_EQ(s.counted(1).complete({0, 0}), 7);
  EXPECT_EQ(s.counted(1).lacks({0, 0}, missing), "update 1 of peer 0 is not in the capture");
  EXPECT_TRUE(missing);
  s.update({0, 0}, 1, 8);
  EXPECT_EQ(s.counted(1).complete({0, 0}), 12);
  EXPECT_EQ(s.counted(1).lacks({0, 0}, missing), "the capture has nothing of peer 0 after tick 12");
  EXPECT_FALSE(missing);
  s.leave({0, 0}, 3, 14);
  EXPECT_EQ(s.counted(1).complete({0, 0}), CountedUpdates::kForever);
  EXPECT_EQ(s.counted(1).complete({3, 9}), -1) << "nobody has admitted it";
}

TEST(CountedUpdates, WhatARemovalVoidsDoesNotCount) {
  Session s;
  s.update({1, 0}, 0, 5).update({1, 0}, 1, 6).update({1, 0}, 2, 20).mark({1, 0}, 3, 20, 10);
  s.removal({0, 0}, 0, 50, {1, 0}, 2).mark({0, 0}, 1, 60, 20);
  const CountedUpdates c = s.counted(2);
  EXPECT_EQ(who(c, 6), std::vector<PeerId>{1});
  EXPECT_EQ(who(c, 20), std::vector<PeerId>{});
  EXPECT_EQ(c.complete({1, 0}), CountedUpdates::kForever);
  EXPECT_TRUE(c.counts({20, 1, {1, 0}, 1})) << "the world before its first update that never happened";
  EXPECT_FALSE(c.counts({21, 1, {1, 0}, 1}));
  EXPECT_TRUE(c.counts({90, 1, {0, 0}, 1}));
}

TEST(CountedUpdates, AnUpdatePassedOnFillsTheLog) {
  Session s;
  s.update({1, 0}, 0, 5).mark({1, 0}, 1, 7, 10);
  s.removal({0, 0}, 0, 50, {1, 0}, 2).mark({0, 0}, 1, 60, 20);
  EXPECT_EQ(s.counted(2).complete({1, 0}), 7);
  sync::Bundle lost;
  lost.peer = 1;
  lost.index = 1;
  lost.tick = 8;
  s.session_log.retold[{1, 1}] = lost;
  EXPECT_EQ(s.counted(2).complete({1, 0}), CountedUpdates::kForever);
  EXPECT_EQ(who(s.counted(2), 8), std::vector<PeerId>{1});
}

TEST(CountedUpdates, OfTwoSidesThatRemoveOneAnotherTheOneThatIsHeardLongerStands) {
  for (const bool first : {true, false}) {
    Session s;
    // Both go on after the partition at tick 30; one side's removal comes earlier by tick, the other is heard longer.
    s.update({0, 0}, 0, 35).removal({0, 0}, 1, 210, {1, 0}, 0);
    s.update({1, 0}, 0, 36).removal({1, 0}, 1, 205, {0, 0}, 0);
    s.mark({0, 0}, 2, 400, first ? 900 : 500).mark({1, 0}, 2, 400, first ? 500 : 900);
    const CountedUpdates c = s.counted(2);
    EXPECT_EQ(who(c, 35), first ? std::vector<PeerId>{0} : std::vector<PeerId>{});
    EXPECT_EQ(who(c, 36), first ? std::vector<PeerId>{} : std::vector<PeerId>{1});
    EXPECT_EQ(c.complete({0, 0}), first ? 400 : CountedUpdates::kForever);
    EXPECT_EQ(c.counts({60, 1, {1, 0}, 1}), !first);
    EXPECT_EQ(c.counts({60, 1, {0, 0}, 1}), first);
  }
}

TEST(CountedUpdates, AdmissionsOfThoseWhoWereAdmittedCount) {
  Session s;
  s.admission({0, 0}, 0, 40, {1, 70}, 0).mark({0, 0}, 1, 50, 1);
  s.update({1, 70}, 0, 45).admission({1, 70}, 1, 60, {2, 90}, 5).mark({1, 70}, 2, 61, 2);
  s.update({2, 90}, 5, 65).mark({2, 90}, 6, 70, 3);
  // Another one sat in the slot by the word of somebody whose word was void.
  s.admission({3, 8}, 0, 41, {1, 71}, 0).update({1, 71}, 0, 45).mark({1, 71}, 1, 99, 4);
  // A slot that the session does not have.
  s.admission({0, 0}, 1, 70, {Session::kSlots, 99}, 0);
  const CountedUpdates c = s.counted(1);
  EXPECT_EQ(c.complete({1, 70}), 61);
  EXPECT_EQ(c.complete({2, 90}), 70);
  EXPECT_EQ(c.complete({1, 71}), -1);
  EXPECT_EQ(c.complete({Session::kSlots, 99}), -1);
  EXPECT_EQ(who(c, 45), std::vector<PeerId>{1});
  EXPECT_EQ(c.unbelievable(), 1U);
}

}  // namespace
}  // namespace padr::capture
