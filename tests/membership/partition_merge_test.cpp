// Which part of a session wins after a partition: a table.
#include "common/membership/partition_merge.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace padr::node
