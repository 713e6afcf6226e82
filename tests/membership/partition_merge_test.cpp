// Which part of a session wins after a partition: a table.
#include "common/membership/partition_merge.h"

#include <gtest/gtest.h>

#include "tests/membership/merge.h"

namespace padr::node {
namespace {

using test::keyed;
using test::Met;
using Side = PartitionMerge::Side;

/// Slot 0 is in its first incarnation unless told otherwise, and so on.
Side side(std::initializer_list<std::pair<int, std::uint32_t>> seats) {
  Side s;
  for (const auto& [slot, incarnation] : seats) s.push_back({static_cast<PeerId>(slot), incarnation, 0});
  return s;
}

struct Case {
  const char* name;
  Side a, b;
  bool a_outranks_b, b_outranks_a;
};

TEST(PartitionMerge, OneOfTwoPartsOutranksTheOther) {
  const Case cases[] = {
      {"more peers", side({{1, 0}, {2, 0}}), side({{0, 0}}), true, false},
      {"the lowest slot", side({{0, 0}, {3, 0}}), side({{1, 0}, {2, 0}}), true, false},
      {"the lower incarnation", side({{0, 1}, {3, 0}}), side({{0, 2}, {2, 0}}), true, false},
      {"the next slot, where the first is alike in both but its incarnation", side({{0, 1}}), side({{0, 7}}), true,
       false},
      {"somebody in both: one's word is old", side({{0, 0}, {1, 0}, {2, 0}}), side({{1, 0}}), false, false},
      {"the same", side({{0, 0}}), side({{0, 0}}), false, false},
      {"nobody", side({}), side({{0, 0}}), false, true},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(PartitionMerge::outranks(c.a, c.b), c.a_outranks_b) << c.name;
    EXPECT_EQ(PartitionMerge::outranks(c.b, c.a), c.b_outranks_a) << c.name << ", the other way round";
  }
}

/// Of slots 0 to 2, and what peer 2 is told by a Probe.
TEST(PartitionMerge, WhatAProbeMeans) {
  using test::kNow;
  struct Row {
    const char* name;
    bool from_member;
    PeerId sender;
    Side members;
    bool knows_you;
    void (*change)(test::Situation&);
    bool joins_anew;
    std::size_t replies;
  };
  const auto nothing = [](test::Situation&) {};
  const Row rows[] = {
      {"a larger part", false, 5, side({{5, 9}, {6, 9}, {7, 9}, {8, 9}}), false, nothing, true, 0},
      {"a smaller part is told of ours", false, 5, side({{5, 9}}), false, nothing, false, 1},
      {"a larger part, some of which is silent here", false, 5, side({{5, 9}, {6, 9}}), false,
       [](test::Situation& s) {
         s.silence(0, kNow - kSilence);
         s.silence(1, kNow - kSilence);
       },
       true, 0},
      {"a part that we are in as well", false, 5, side({{2, 3}, {5, 9}, {6, 9}, {7, 9}}), false, nothing, false, 1},
      {"a member that knows us", true, 1, side({{5, 9}, {6, 9}, {7, 9}, {8, 9}}), true, nothing, false, 0},
      {"a member that has evicted us", true, 1, side({{0, 1}, {1, 2}}), false,
       [](test::Situation& s) { s.silence(0, kNow - kSilence); }, true, 0},
      {"said in another incarnation", true, 7, side({{5, 9}, {6, 9}, {7, 9}, {8, 9}}), false, nothing, false, 0},
      {"we have only just come", false, 5, side({{5, 9}, {6, 9}, {7, 9}, {8, 9}}), false,
       [](test::Situation& s) { s.roster.in_since = kNow - PartitionMerge::kGrace + 1; }, false, 0},
      {"we are no member", false, 5, side({{5, 9}, {6, 9}, {7, 9}, {8, 9}}), false,
       [](test::Situation& s) { s.roster.member = false; }, false, 0},
  };
  for (const Row& r : rows) {
    test::Situation s(9, 2);
    for (PeerId p = 3; p < 9; ++p) s.empty(p);
    r.change(s);
    wire::Probe probe;
    probe.members = r.members;
    probe.knows_you = r.knows_you;
    probe.newest = 9;
    probe.incarnation = s.roster.seats[r.sender].incarnation;
    const Endpoint from = r.from_member ? test::Situation::at(1) : ipv4({10, 9, 9, 9}, 1);
    PartitionMerge rules(s.session);
    test::ListedCommands out;
    rules.on_probe(from, r.sender, probe, wire::kMaxDatagram, s.view(), 0, out);
    EXPECT_EQ(rules.winner(s.view()) == from, r.joins_anew) << r.name;
    EXPECT_EQ(out.all<wire::Probe>().size(), r.replies) << r.name;
  }
}

/// With a key, as peer 2 sees it: persons 0 to 2 are its part, 5 to 7 were evicted at tick 900, and person 8 never was
/// a member. All Probes list twelve peers.
TEST(PartitionMerge, WithAKeyOnlyWhoWasAMemberAndSpeaksForItselfCounts) {
  using test::kNow;
  constexpr Tick kRemoved = 900;
  struct Row {
    const char* name;
    std::vector<int> heard;    ///< persons whose Probes have come, the last one just now
    Tick theirs;               ///< first admission of those that were evicted
    std::array<Tick, 3> ours;  ///< first admissions in our part
    bool joins_anew;
  };
  const Row rows[] = {
      {"one who lists twelve", {5}, 10, {0, 20, 30}, false},
      {"a stranger that lists twelve", {8}, 10, {0, 20, 30}, false},
      {"the same that says it often", {5, 5, 5, 5}, 10, {0, 20, 30}, false},
      {"two of three and a stranger", {5, 8, 6}, 10, {0, 20, 30}, false},
      {"three of three, but we have the most senior", {5, 6, 7}, 10, {0, 20, 30}, false},
      {"three of three, the more senior", {5, 6, 7}, 10, {15, 20, 30}, true},
      {"the last one to speak is a stranger", {5, 6, 7, 8}, 10, {15, 20, 30}, true},
      {"two, and one of us has come since", {5, 6}, 10, {15, 20, 950}, true},
      {"two, and one of us had hardly come", {5, 6}, 10, {15, 20, kRemoved - PartitionMerge::kMayBeUnknown + 1}, true},
      {"two, and one of us had been here long enough",
       {5, 6},
       10,
       {15, 20, kRemoved - PartitionMerge::kMayBeUnknown},
       false},
      {"one, and all of us have come since", {5}, 10, {910, 920, 930}, true},
      {"nobody had been here for long: the most senior decides", {5}, 700, {690, 910, 920}, false},
      {"the same, the other way round", {5}, 700, {710, 910, 920}, true},
      {"nobody had been here for long: more decide", {5, 6}, 700, {690, 910, 920}, true},
  };
  for (const Row& r : rows) {
    test::Situation s(9, 2);
    s.session.config.sealed = true;
    for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
    for (PeerId p = 3; p < 9; ++p) s.empty(p);
    s.roster.seats[0].since = r.ours[0];
    s.roster.seats[1].since = r.ours[1];
    s.roster.in_since = std::min(r.ours[2], kNow - PartitionMerge::kGrace);
    PartitionMerge rules(s.session);
    for (int person = 5; person < 8; ++person) rules.remember({keyed(person), r.theirs, kRemoved}, kRemoved);
    wire::Probe probe;
    for (PeerId p = 3; p < 12; ++p) probe.members.push_back({p, 1U + p, 0});
    test::ListedCommands out;
    for (const int person : r.heard) {
      probe.incarnation = 1U + static_cast<std::uint32_t>(person);
      rules.on_probe(keyed(person), static_cast<PeerId>(person), probe, wire::kMaxDatagram, s.view(), 0, out);
    }
    EXPECT_EQ(rules.winner(s.view()).has_value(), r.joins_anew) << r.name;
  }
}

// Once, the part of a senior peer stayed as it counted that one, and the other part as it had barred it.
TEST(PartitionMerge, WhoIsBarredForAWhileCountsButIsNotFollowed) {
  for (const bool barred_speaks : {true, false}) {
    Met m({50, 50, 50}, 3);
    m.probe.incarnation = 6;
    if (barred_speaks) m.rules.on_probe_of_barred(keyed(5), 5, m.probe, m.s.view());
    EXPECT_FALSE(m.yields());
    m.probed_by(6, 7);
    EXPECT_EQ(m.yields(), barred_speaks);
    if (m.yields()) {
      EXPECT_NE(*m.rules.winner(m.s.view()), keyed(5));
    }
    m.probe.incarnation = 6;
    m.rules.on_probe_of_barred(keyed(5), 5, m.probe, m.s.view());
    if (m.yields()) {
      EXPECT_NE(*m.rules.winner(m.s.view()), keyed(5));
    }
  }
}

// Once, two parts whose peers had all joined anew stayed apart for ever.
TEST(PartitionMerge, StrangersAreBelievedAfterAWhileIfTheyAreMore) {
  using test::kNow;
  for (const Tick met : {kNow - PartitionMerge::kStrangers, kNow - PartitionMerge::kStrangers + 1}) {
    for (const int heard : {1, 4}) {
      test::Situation s(9, 2);
      s.session.config.sealed = true;
      for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
      for (PeerId p = 3; p < 9; ++p) s.empty(p);
      PartitionMerge rules(s.session);
      for (int person = 5; person < 9; ++person) rules.remember({keyed(person), met, met}, met);
      wire::Probe probe;
      for (PeerId p = 3; p < 12; ++p) probe.members.push_back({p, 1U + p, 0});
      test::ListedCommands out;
      for (int person = 5; person < 5 + heard; ++person) {
        probe.incarnation = 1U + static_cast<std::uint32_t>(person);
        rules.on_probe(keyed(person), static_cast<PeerId>(person), probe, wire::kMaxDatagram, s.view(), 0, out);
      }
      const bool long_ago = met == kNow - PartitionMerge::kStrangers;
      EXPECT_EQ(rules.winner(s.view()).has_value(), long_ago && heard == 4) << kNow - met << " " << heard;
    }
  }
}

// The most senior of all is alone; one part has two newcomers that the other cannot know. Once, each stayed, as one of
// them counted more peers that had not been here for long.
TEST(PartitionMerge, BothPartsComeToTheSameThoughOneHasNewcomers) {
  Met many({800, 20, 940}, 1);
  many.s.roster.seats[3] = many.s.roster.seats[0];
  many.s.roster.seats[3].incarnation = 4;
  many.s.roster.seats[3].at = keyed(3);
  many.s.roster.seats[3].since = 945;
  many.rules.remember({keyed(6), 10, 900}, 900);
  for (auto& m : many.probe.members) m.slot += 20;
  many.probe.members.push_back({6, 7, 0});
  many.probed_by(6, 6);
  EXPECT_TRUE(many.yields());

  Met alone({0, 0, 10}, 0);
  for (const PeerId p : {PeerId{0}, PeerId{1}}) alone.s.empty(p);
  alone.rules.remember({keyed(5), 20, 900}, 900);
  alone.rules.remember({keyed(6), 800, 905}, 905);
  alone.probed_by(5, 6);
  EXPECT_FALSE(alone.yields());
}

// Once, a place that was known from elsewhere hid that its peer had been the most senior here, and of two that were
// alone each took itself for the more senior one.
TEST(PartitionMerge, AnEvictionCountsThoughItsPeersPlaceWasKnown) {
  test::Situation s(4, 2);
  PartitionMerge rules(s.session);
  rules.remember({keyed(0), 950, 950}, 950);
  rules.on_change({MemberChange::Kind::kRemoved, 0, 1, keyed(0), 940, 1, 0}, s.view());
  rules.remember({keyed(0), 960, 960}, 960);
  ASSERT_EQ(rules.gone().size(), 1U);
  EXPECT_EQ(rules.gone()[0].since, 0);
  EXPECT_EQ(rules.gone()[0].removed, 940);
}

// Once, each of two parts yielded to the other, as each went by what it knew, and neither let anybody in.
TEST(PartitionMerge, OfTwoThatYieldTheLargerOneStays) {
  for (const int theirs : {1, 2, 3, 4}) {
    for (const bool they_yield : {false, true}) {
      Met met({500, 600, 700}, theirs);  // all of us have come since: none of us counts
      met.probe.yields = they_yield;
      met.probed_by(5, 4 + theirs);
      EXPECT_EQ(met.yields(), !they_yield || theirs >= 3) << theirs << " " << they_yield;
    }
  }
}

// Once, a newcomer that a liar of high seniority had let in stayed with it for ever, beside four others; and so did who
// was alone, beside three others of whom it could know only one.
TEST(PartitionMerge, SeniorityKeepsTheSmallerPartApartForAWhileOnly) {
  for (const auto& [ours, theirs] : {std::pair(3, 2), std::pair(3, 3), std::pair(1, 1), std::pair(1, 2)}) {
    SCOPED_TRACE(std::to_string(ours) + " and " + std::to_string(theirs));
    Met met({5, 6, 7}, 0);
    for (int person = 5; person < 5 + theirs; ++person)
      met.rules.remember({keyed(person), person == 5 ? 20 : 800, 900}, 900);
    for (PeerId p = 0; p < 3 - ours; ++p) met.s.empty(p);
    const Tick begin = met.s.roster.now;
    const Tick patience = theirs > 1 ? PartitionMerge::kStrangers : PartitionMerge::kAlone;
    for (; met.s.roster.now < begin + patience; met.s.roster.now += PartitionMerge::kPace) {
      for (PeerId p = 0; p < 2; ++p) met.s.roster.seats[p].answered = met.s.roster.now;
      met.probed_by(5, 4 + theirs);
      ASSERT_FALSE(met.yields()) << met.s.roster.now - begin;
    }
    met.probed_by(5, 4 + theirs);
    EXPECT_EQ(met.yields(), theirs >= ours);
  }
}

// Once, one of five, which had not itself seen the most senior peer lie, went over to that one again and again, as all
// the others had come after its eviction.
TEST(PartitionMerge, SeniorityOfASinglePeerMovesNoLargerPart) {
  for (const bool one_was_there : {true, false}) {
    for (const std::size_t listed : {1U, 2U, 3U, 4U}) {
      SCOPED_TRACE(std::to_string(listed) + (one_was_there ? " and one of us was there" : ""));
      Met met({one_was_there ? 50 : 910, 920, 930}, 0);
      met.s.roster.in_since = 930;
      met.rules.remember({keyed(5), 20, 900}, 900);
      met.probe.members.clear();
      for (std::size_t i = 0; i < listed; ++i)
        met.probe.members.push_back({static_cast<PeerId>(5 + i), static_cast<std::uint32_t>(6 + i), 0});
      met.probed_by(5, 5);
      EXPECT_EQ(met.yields(), !one_was_there || listed >= 3) << "whom that one cannot know, it cannot join";
    }
  }
}

// Once, a liar that its own part no longer counted listed that part and itself. Each of two parts then took the other
// one for the winner, and neither let anybody in for half a minute.
TEST(PartitionMerge, WhomItsOwnPartDoesNotCountIsNoneOfThem) {
  for (const bool counted : {false, true}) {
    Met met({5, 6, 7}, 0);
    for (int person = 5; person < 9; ++person) met.rules.remember({keyed(person), 20, 900}, 900);
    const auto listing = [&](int last) {
      met.probe.members.clear();
      for (int person = 5; person <= last; ++person)
        met.probe.members.push_back({static_cast<PeerId>(person), 1U + static_cast<std::uint32_t>(person), 0});
    };
    listing(counted ? 8 : 7);
    met.probed_by(5, 7);
    listing(8);
    met.probed_by(8, 8);
    EXPECT_EQ(met.yields(), counted);
  }
}

// Once, a member stayed for 30 s with a senior liar by which nothing was confirmed, beside a part of the same size.
TEST(PartitionMerge, SeniorityKeepsNobodyWhereNothingIsConfirmed) {
  for (const int both : {1, 2, 3}) {
    for (const bool stalled : {false, true}) {
      SCOPED_TRACE(std::to_string(both) + (stalled ? " stalled" : ""));
      Met met({5, 6, 7}, 0);
      for (int person = 5; person < 5 + both; ++person) met.rules.remember({keyed(person), 20, 900}, 900);
      for (PeerId p = 0; p < 3 - both; ++p) met.s.empty(p);
      met.rules.set_stalled(stalled);
      met.probed_by(5, 4 + both);
      EXPECT_EQ(met.yields(), stalled && both > 1) << "a single one may be a liar";
    }
  }
}

// Once, of two parts of three neither yielded: the one did not count a witness that it might have been the only one to
// know, and took itself for the more senior one, but counted a newcomer of its own against the others.
TEST(PartitionMerge, AgainstTheLargerPartNoNewcomerCounts) {
  for (const bool newcomer : {false, true}) {
    for (const bool they_yield : {false, true}) {
      SCOPED_TRACE(std::to_string(newcomer) + std::to_string(they_yield));
      Met met({5, newcomer ? 950 : 6, 7}, 0);
      for (int person = 5; person < 8; ++person) met.rules.remember({keyed(person), person == 5 ? 20 : 800, 900}, 900);
      met.probe.members.clear();
      for (int person = 5; person < 8; ++person)
        met.probe.members.push_back({static_cast<PeerId>(person), 1U + static_cast<std::uint32_t>(person), 0});
      met.probe.yields = they_yield;
      const Tick begin = met.s.roster.now;
      for (; met.s.roster.now <= begin + PartitionMerge::kStrangers; met.s.roster.now += PartitionMerge::kPace) {
        ASSERT_FALSE(met.yields()) << met.s.roster.now - begin;
        for (PeerId p = 0; p < 2; ++p) met.s.roster.seats[p].answered = met.s.roster.now;
        met.probed_by(5, 7);
      }
      EXPECT_EQ(met.yields(), newcomer && !they_yield);
    }
  }
}

// Once, two such parts never merged: each took the other's peer for its own, and this peer took it for itself.
TEST(PartitionMerge, BothPartsMayHaveGivenOneSlotAndIncarnation) {
  for (const PeerId slot : {PeerId{1}, PeerId{2}}) {
    for (const bool speaks : {false, true}) {
      SCOPED_TRACE(std::to_string(slot) + (speaks ? " speaks" : " is silent"));
      Met met({20, 920, 930}, 3);
      const std::uint32_t incarnation = met.s.roster.incarnation_of(slot);
      met.rules.on_change({MemberChange::Kind::kAdmitted, 2, 40, keyed(2), 40, 0, 40}, met.s.view());
      met.probe.members = side({{slot, incarnation}, {6, 7}, {7, 8}});
      met.probe.incarnation = incarnation;
      if (speaks) met.rules.on_probe(keyed(5), slot, met.probe, wire::kMaxDatagram, met.s.view(), 0, met.out);
      EXPECT_TRUE(met.rules.knows(keyed(5), met.s.view())) << "it is looked for";
      met.probed_by(6, 7);
      EXPECT_EQ(met.yields(), speaks);
    }
  }
}

// Once, two members tried for ever to join a more senior liar, which let nobody in, and let nobody in themselves. And
// of two that were alone, one tried to join the liar, and the other one to join the first.
TEST(PartitionMerge, WhoJoinsAWinnerInVainStaysForAWhile) {
  for (const bool alone : {false, true})
    for (const bool it_yields : {false, true}) {
      SCOPED_TRACE(std::string(alone ? "alone" : "three") + (it_yields ? ", the winner yields" : ""));
      Met met({5, 6, 7}, 4);
      if (alone)
        for (const PeerId p : {PeerId{0}, PeerId{1}}) met.s.empty(p);
      else if (it_yields)
        continue;  // the senior one yields, and is not the larger one
      met.probe.yields = it_yields;
      met.rules.advance(met.s.view(), met.out);
      const Tick begin = met.s.roster.now + PartitionMerge::kPace;
      const Tick tries = (it_yields ? 2 : 1) * PartitionMerge::kInVain;
      const Tick stays = alone ? PartitionMerge::kStaysAlone : PartitionMerge::kInVain;
      bool replied = false;
      std::vector<std::pair<bool, Tick>> turns;  // whether it yields, and for how long
      for (Tick t = 0; t < 2 * (tries + stays); t += PartitionMerge::kPace) {
        met.s.roster.now = begin + t;
        for (PeerId p = 0; p < 2; ++p) met.s.roster.seats[p].answered = met.s.roster.now;
        const std::size_t sent = met.out.all<wire::Probe>().size();
        met.probed_by(5, 8);
        replied |= met.out.all<wire::Probe>().size() > sent;
        if (turns.empty() || turns.back().first != met.yields()) turns.emplace_back(met.yields(), 0);
        turns.back().second += PartitionMerge::kPace;
        met.rules.advance(met.s.view(), met.out);
      }
      ASSERT_GE(turns.size(), 3U);
      EXPECT_TRUE(turns[0].first);
      EXPECT_NEAR(turns[0].second, tries, 2 * PartitionMerge::kPace);
      EXPECT_NEAR(turns[1].second, stays, 2 * PartitionMerge::kPace);
      EXPECT_TRUE(replied) << "the other part still hears of this one";
    }
}

}  // namespace
}  // namespace padr::node
