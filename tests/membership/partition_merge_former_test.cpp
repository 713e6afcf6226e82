// What the partition merge remembers of whoever was evicted or has left.
#include "common/membership/partition_merge.h"

#include <gtest/gtest.h>

#include "tests/membership/merge.h"

namespace padr::node {
namespace {

using test::keyed;

// A part's new coordinator tells its joiners who was first admitted when, even of a peer that has come back since.
TEST(PartitionMerge, WhoComesBackIsAsSeniorAsBefore) {
  test::Situation s(9, 2);
  s.session.config.sealed = true;
  for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
  PartitionMerge rules(s.session);
  using Kind = MemberChange::Kind;
  rules.on_change({Kind::kRemoved, 4, 5, keyed(4), 500, 0, 100}, s.view());
  ASSERT_EQ(rules.gone().size(), 1U);
  EXPECT_EQ(rules.gone()[0].since, 100);
  EXPECT_EQ(rules.gone()[0].removed, 500);
  s.roster.seats[4].at = Endpoint{};
  s.roster.seats[6].at = keyed(4);
  s.roster.seats[6].since = 700;
  rules.on_change({Kind::kAdmitted, 6, 40, keyed(4), 700, 0, 700}, s.view());
  EXPECT_TRUE(rules.gone().empty());
  EXPECT_EQ(rules.since(6, s.view()), 100);
  rules.on_change({Kind::kRemoved, 6, 40, keyed(4), 900, 0, 700}, s.view());
  ASSERT_EQ(rules.gone().size(), 1U);
  EXPECT_EQ(rules.gone()[0].since, 100);
}

// Once, one that came back again and again was remembered once for each time, and others were forgotten for it.
TEST(PartitionMerge, WhoComesBackOftenTakesNobodysSeniority) {
  test::Situation s(9, 2);
  s.session.config.sealed = true;
  for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
  PartitionMerge rules(s.session);
  const auto comes_back = [&](PeerId p, Tick tick) {
    s.roster.now = tick;
    s.roster.seats[p].since = tick;
    rules.on_change({MemberChange::Kind::kRemoved, p, 5, keyed(p), tick - 1, 0, 100}, s.view());
    rules.on_change({MemberChange::Kind::kAdmitted, p, 6, keyed(p), tick, 0, tick}, s.view());
  };
  comes_back(4, 1000);
  for (Tick n = 0; n < 100; ++n) comes_back(5, 2000 + 60 * n);
  EXPECT_EQ(rules.since(5, s.view()), 100);
  EXPECT_EQ(rules.since(4, s.view()), 100);
}

// They left to join anew, and have found others than those who stayed. Once, whoever had stayed alone stayed so.
TEST(PartitionMerge, WhoHasLeftCountsInTheOtherPartAndIsNotLookedFor) {
  test::Situation s(9, 2);
  s.session.config.sealed = true;
  for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
  for (PeerId p = 3; p < 9; ++p) s.empty(p);
  s.roster.in_since = 10;
  PartitionMerge rules(s.session);
  for (const PeerId p : {PeerId{0}, PeerId{1}}) {
    s.roster.seats[p].presence = Presence::kLeft;
    rules.on_change({MemberChange::Kind::kLeft, p, 1U + p, keyed(p), 900, p, 20}, s.view());
    s.roster.seats[p].heard = test::kNow - Roster::kDeparted;
  }
  s.roster.now += Roster::kDeparted;
  test::ListedCommands out;
  rules.advance(s.view(), out);
  EXPECT_TRUE(out.all<wire::Probe>().empty());
  EXPECT_TRUE(rules.gone().empty());
  for (const PeerId p : {PeerId{0}, PeerId{1}}) {
    EXPECT_FALSE(rules.winner(s.view())) << "one is no more than we are, who are senior";
    wire::Probe probe;
    probe.members = {{5, 10, 0}, {6, 11, 0}};
    probe.incarnation = 10U + p;
    rules.on_probe(keyed(p), static_cast<PeerId>(5 + p), probe, wire::kMaxDatagram, s.view(), 0, out);
  }
  EXPECT_TRUE(rules.winner(s.view()));
}

}  // namespace
}  // namespace padr::node
