// Which part of a session wins after a partition: a table.
#include "common/membership/partition_merge.h"

#include <gtest/gtest.h>

#include "tests/membership/rules.h"

namespace padr::node {
namespace {

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

}  // namespace
}  // namespace padr::node
