// Whom a part looks for after a partition, and what it tells the other part.
#include <algorithm>
#include <optional>

#include "tests/membership/merge.h"

namespace padr::node {
namespace {

using test::keyed;
using test::Met;

// Persons 0 and 1 were members, and have ended; person 1 had joined another part before, and told of person 6 there.
// Once, both parts stayed apart for ever.
TEST(PartitionMerge, WhoHasBeenAloneForLongGoesToThoseOfWhomAFormerMemberHasTold) {
  struct Row {
    const char* name;
    int by;                 ///< who has told of person 6
    bool alone;             ///< person 0 has ended
    Tick waits;             ///< since person 1 has ended, ticks
    std::size_t looks_for;  ///< Probes to person 6 at the end
    bool yields;
  };
  constexpr Tick kLong = PartitionMerge::kAlone + PartitionMerge::kInVain / 2;
  const Row rows[] = {
      {"a former member", 1, true, kLong, 1, true},
      {"a short time", 1, true, PartitionMerge::kAlone - PartitionMerge::kPace, 0, false},
      {"in company", 1, false, kLong, 0, false},
      {"a stranger", 7, true, kLong, 0, false},
  };
  for (const Row& r : rows) {
    SCOPED_TRACE(r.name);
    Met met({5, 6, 7}, 0);
    met.rules.advance(met.s.view(), met.out);
    met.s.roster.now += PartitionMerge::kPace;
    for (const PeerId p : {PeerId{0}, PeerId{1}}) {
      if (p == 0 && !r.alone) continue;
      met.s.empty(p);
      met.rules.on_change({MemberChange::Kind::kRemoved, p, 1U + p, keyed(p), met.s.roster.now, p, 5}, met.s.view());
    }
    met.rules.on_told(keyed(r.by), keyed(6), met.s.view());
    std::size_t probes = 0;
    for (const Tick end = met.s.roster.now + r.waits; met.s.roster.now < end;
         met.s.roster.now += PartitionMerge::kPace) {
      met.s.roster.seats[0].answered = met.s.roster.now;
      test::ListedCommands out;
      met.rules.advance(met.s.view(), out);
      met.probed_by(6, 6);
      const auto sent = out.all<wire::Probe>();
      probes = static_cast<std::size_t>(
          std::count_if(sent.begin(), sent.end(), [](const auto& probe) { return probe.to == keyed(6); }));
    }
    EXPECT_EQ(probes, r.looks_for);
    EXPECT_EQ(met.yields(), r.yields);
  }
}

// A lying coordinator may name any place. Once, it made this part forget the members of the other one.
TEST(PartitionMerge, WhoIsSaidToBeAtALostPeersPlaceDoesNotHideIt) {
  for (const bool same_key : {false, true}) {
    SCOPED_TRACE(same_key ? "it is back" : "somebody else");
    Met met({15, 20, 30}, 0);
    for (const PeerId p : {PeerId{5}, PeerId{6}, PeerId{7}}) {
      met.rules.on_change({MemberChange::Kind::kRemoved, p, 1U + p, keyed(p), 900, 0, 10}, met.s.view());
      Endpoint at = keyed(same_key ? p : 8);
      at.port = keyed(p).port;
      at.address = keyed(p).address;
      met.rules.on_change({MemberChange::Kind::kAdmitted, 8, 20U + p, at, 950, 1, 950}, met.s.view());
    }
    EXPECT_TRUE(met.rules.gone().empty()) << "nobody is looked for where a member is";
    met.probed_by(5, 7);
    EXPECT_EQ(met.yields(), !same_key);
  }
}

// Its process has ended, and another one that listens there is a member before the eviction. Once, that one was sent
// Probes for the former one, which it could not read, for twenty minutes.
TEST(PartitionMerge, NobodyIsLookedForWhereAnotherMemberIs) {
  for (const bool same_place : {true, false}) {
    SCOPED_TRACE(same_place);
    Met met({15, 20, 30}, 0);
    Endpoint at = keyed(8);
    if (same_place) {
      at.address = keyed(5).address;
      at.port = keyed(5).port;
    }
    met.s.roster.seat(3, 20, 0, at, 950);
    met.rules.on_change({MemberChange::Kind::kAdmitted, 3, 20, at, 950, 1, 950}, met.s.view());
    met.rules.on_change({MemberChange::Kind::kRemoved, 5, 6, keyed(5), 960, 0, 10}, met.s.view());
    EXPECT_EQ(met.rules.gone().empty(), same_place);
    met.rules.advance(met.s.view(), met.out);
    EXPECT_EQ(met.out.all<wire::Probe>().empty(), same_place);
  }
}

// Both are alone, and only this one has been told of the other. Once, it waited for the other to come, as the own part
// ranks first.
TEST(PartitionMerge, OfTwoThatAreAloneTheOneThatKnowsOfTheOtherGoesInTheEnd) {
  for (const PeerId other : {PeerId{1}, PeerId{6}}) {
    for (const bool yields : {false, true}) {
      SCOPED_TRACE(std::to_string(other) + " " + std::to_string(yields));
      Met met({5, 6, 7}, 0);
      met.rules.advance(met.s.view(), met.out);
      for (const PeerId p : {PeerId{0}, PeerId{1}}) met.s.empty(p);
      met.rules.on_change({MemberChange::Kind::kRemoved, 0, 1, keyed(0), test::kNow, 0, 5}, met.s.view());
      met.rules.on_told(keyed(0), keyed(6), met.s.view());
      met.probe.members = {{other, 7, 0}};
      met.probe.incarnation = 7;
      met.probe.yields = yields;
      std::optional<Tick> went;
      for (const Tick begin = met.s.roster.now; !went && met.s.roster.now < begin + 2 * PartitionMerge::kLonely;
           met.s.roster.now += PartitionMerge::kPace) {
        met.rules.advance(met.s.view(), met.out);
        met.rules.on_probe(keyed(6), other, met.probe, wire::kMaxDatagram, met.s.view(), 0, met.out);
        if (met.yields()) went = met.s.roster.now - begin;
      }
      ASSERT_EQ(went.has_value(), other == 1 || !yields);
      if (!went) continue;
      EXPECT_EQ(*went < PartitionMerge::kLonely - PartitionMerge::kPace, other == 1) << *went;
    }
  }
}

// Once, so many made this peer forget all that it had been parted from.
TEST(PartitionMerge, ManyThatComeAndGoDisplaceNobodyThatIsLost) {
  Met met({10, 20, 30}, 4);
  ASSERT_EQ(met.rules.gone().size(), 4U);
  for (int person = 20; person < 20 + 2 * static_cast<int>(PartitionMerge::kMost); ++person)
    met.rules.on_change({MemberChange::Kind::kLeft, 4, 100U, keyed(person), 900, 4, 20}, met.s.view());
  EXPECT_EQ(met.rules.gone().size(), 4U);
  for (int person = 150; person < 150 + static_cast<int>(PartitionMerge::kMost); ++person)
    met.rules.remember({keyed(person), 10, 100}, 100);
  EXPECT_EQ(met.rules.gone().size(), PartitionMerge::kMost);
}

// Once, whoever had the key could tell the smaller part to join it elsewhere, by repeating the larger one's list.
TEST(PartitionMerge, OnlyAMemberOfTheOtherPartIsJoined) {
  Met met({800, 810, 820}, 4);
  met.probed_by(5, 8);
  ASSERT_TRUE(met.yields());
  const Endpoint before = *met.rules.winner(met.s.view());
  met.probe.incarnation = 5;
  met.rules.on_probe(keyed(30), 4, met.probe, wire::kMaxDatagram, met.s.view(), 0, met.out);
  EXPECT_EQ(met.rules.winner(met.s.view()), before);
}

// Person 1 was a member with this peer's former incarnation. Once, this one took it for a stranger, and the other one,
// which was the more senior, stayed where it was, too.
TEST(PartitionMerge, WhoIsAloneGoesByWhatItsFormerIncarnationKnew) {
  for (const bool alone : {true, false}) {
    SCOPED_TRACE(alone);
    Met before({5, 6, 7}, 0);
    Met met({800, 0, 800}, 0);
    met.s.empty(1);
    if (alone) met.s.empty(0);
    const Tick begin = met.s.roster.now;
    met.rules.inherit(before.rules, before.s.view(), begin);
    met.probe.members = {{8, 2, 0}};
    met.probe.incarnation = 2;
    std::optional<Tick> went;
    for (; !went && met.s.roster.now < begin + PartitionMerge::kAlone; met.s.roster.now += PartitionMerge::kPace) {
      met.s.roster.seats[0].answered = met.s.roster.now;
      met.rules.advance(met.s.view(), met.out);
      met.rules.on_probe(keyed(1), 8, met.probe, wire::kMaxDatagram, met.s.view(), 0, met.out);
      if (met.yields()) went = met.s.roster.now - begin;
    }
    ASSERT_EQ(went.has_value(), alone);
    EXPECT_EQ(went.value_or(PartitionMerge::kStrangers), PartitionMerge::kStrangers);
  }
}

TEST(PartitionMerge, WithItsProbesEachPartTellsOfItsOwnPeersInTurn) {
  for (const bool sealed : {true, false}) {
    Met met({5, 6, 7}, 1);
    met.s.session.config.sealed = sealed;
    std::vector<Endpoint> told;
    for (int i = 0; i < 4; ++i) {
      met.rules.advance(met.s.view(), met.out);
      met.s.roster.now += PartitionMerge::kTell;
    }
    for (const auto& sent : met.out.all<wire::Newcomer>()) {
      EXPECT_EQ(sent.to, keyed(5));
      told.push_back(sent.message.at);
    }
    const std::vector in_turn{keyed(1), keyed(0), keyed(1), keyed(0), keyed(1)};  // of all at first
    EXPECT_EQ(told, sealed ? in_turn : std::vector<Endpoint>{});
  }
}

// The other part answers answers, too. Once, two parts that did not merge exchanged them as fast as the network let
// them.
TEST(PartitionMerge, EachProbeIsAnsweredButNotEachAnswer) {
  for (const bool sealed : {true, false}) {
    Met met({5, 6, 7}, 2);
    met.s.session.config.sealed = sealed;
    met.probe.members = {{8, 9, 0}};
    for (Tick t = 0; t < 3 * PartitionMerge::kPace; ++t, ++met.s.roster.now) met.probed_by(5, 6);
    EXPECT_EQ(met.out.all<wire::Probe>().size(), 2U * 3 * PartitionMerge::kPace / PartitionMerge::kAnswerPace)
        << sealed;
  }
}

// Once, nobody looked for a peer that had left slot 1, joined anew, and was then evicted.
TEST(PartitionMerge, AnEvictedPeerIsLookedForThoughItHadLeftAnotherSlot) {
  test::Situation s(4, 2);
  PartitionMerge rules(s.session);
  s.roster.seats[1].presence = Presence::kLeft;
  const Endpoint at = s.roster.seats[1].at;
  s.empty(3);
  rules.remember({at, 0, 900}, 900);
  const auto probes = [&] {
    test::ListedCommands out;
    s.roster.now += PartitionMerge::kPace;
    rules.advance(s.view(), out);
    return out.all<wire::Probe>().size();
  };
  s.roster.seats[1].heard = s.roster.now;
  EXPECT_EQ(probes(), 0U) << "it lingers there";
  s.roster.seats[1].heard = s.roster.now - Roster::kDeparted;
  EXPECT_EQ(probes(), 1U);
}

// They left this session, as this peer had left the one before it, to join anew, and linger. Once, it looked for none
// of them, forgot that they had been members, and stayed alone.
TEST(PartitionMerge, WhoHasLeftIsLookedForWhereAFormerIncarnationKnewIt) {
  test::Situation s(4, 2);
  s.session.config.sealed = true;
  for (PeerId p = 0; p < 4; ++p) s.roster.seats[p].at = keyed(p);
  s.empty(3);
  PartitionMerge rules(s.session);
  for (const PeerId p : {PeerId{0}, PeerId{1}}) {
    s.roster.seats[p].presence = Presence::kLeft;
    rules.on_change({MemberChange::Kind::kLeft, p, 1U + p, keyed(p), 900, p, 20}, s.view());
    rules.remember({keyed(p), 950, 950}, 950);
  }
  const auto probes = [&] {
    test::ListedCommands out;
    s.roster.now += PartitionMerge::kPace;
    rules.advance(s.view(), out);
    return out.all<wire::Probe>().size();
  };
  for (const PeerId p : {PeerId{0}, PeerId{1}}) s.roster.seats[p].heard = s.roster.now;
  EXPECT_EQ(probes(), 0U);
  for (const PeerId p : {PeerId{0}, PeerId{1}}) s.roster.seats[p].heard = s.roster.now - Roster::kDeparted;
  EXPECT_EQ(probes(), 2U);
  ASSERT_EQ(rules.gone().size(), 2U);
  EXPECT_EQ(rules.gone()[0].since, 20);
  EXPECT_EQ(rules.gone()[0].removed, 900);
}

// It has left to join anew, and then all others have ended.
TEST(PartitionMerge, WhoHasLeftAndIsAloneGoesToWhoeverIsThere) {
  for (const bool leaving : {true, false}) {
    for (const bool alone : {true, false}) {
      test::Situation s(9, 2);
      s.session.config.sealed = true;
      for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
      for (PeerId p = alone ? 0 : 1; p < 9; ++p)
        if (p != 2) s.empty(p);
      s.roster.leaving = leaving;
      PartitionMerge rules(s.session);
      test::ListedCommands out;
      wire::Probe probe;
      probe.members = {{5, 10, 0}};
      probe.incarnation = 10;
      rules.on_probe(keyed(8), 5, probe, wire::kMaxDatagram, s.view(), 0, out);
      EXPECT_EQ(rules.winner(s.view()).has_value(), leaving && alone);
    }
  }
}

}  // namespace
}  // namespace padr::node
