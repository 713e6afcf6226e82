// Links that are cut for a while.
#include "peer/link_cuts.h"

#include <gtest/gtest.h>

namespace padr::test {
namespace {

Endpoint at(std::uint8_t n) {
  Endpoint e;
  e.address[15] = n;
  e.port = 7000;
  return e;
}

TEST(LinkCuts, OneOrAllUntilTheirTime) {
  peer::LinkCuts cuts;
  EXPECT_FALSE(cuts.any());
  cuts.cut(PeerId{2}, {at(2), at(4)}, 1000);
  EXPECT_TRUE(cuts.is_cut_out(at(2)));
  EXPECT_TRUE(cuts.is_cut_out(at(4))) << "it may be at either";
  EXPECT_FALSE(cuts.is_cut_out(at(3)));
  cuts.cut({}, {}, 500);
  EXPECT_TRUE(cuts.is_cut_out(at(3)));
  EXPECT_EQ(cuts.next_due(), 500);
  EXPECT_EQ(cuts.take_over(499), std::vector<PeerId>{});
  EXPECT_EQ(cuts.take_over(500), std::vector<PeerId>{kNoPeer});
  EXPECT_FALSE(cuts.is_cut_out(at(3)));
  EXPECT_EQ(cuts.take_over(1000), std::vector<PeerId>{2});
  EXPECT_FALSE(cuts.any());
}

TEST(LinkCuts, OneWay) {
  peer::LinkCuts cuts;
  cuts.cut(PeerId{2}, {at(2)}, 1000, monitor::Ways::kOut);
  EXPECT_TRUE(cuts.is_cut_out(at(2)));
  EXPECT_FALSE(cuts.is_cut_in(at(2)));
  cuts.cut({}, {}, 500, monitor::Ways::kIn);
  EXPECT_TRUE(cuts.is_cut_in(at(2)));
  EXPECT_TRUE(cuts.is_cut_in(at(3)));
  EXPECT_FALSE(cuts.is_cut_out(at(3)));
  cuts.cut(PeerId{2}, {at(2)}, 1000);
  EXPECT_EQ(cuts.take_over(500), std::vector<PeerId>{kNoPeer});
  EXPECT_TRUE(cuts.is_cut_in(at(2)));
  EXPECT_TRUE(cuts.is_cut_out(at(2)));
}

// In a session with a key a peer is known by its key, and its datagrams by where they come from.
TEST(LinkCuts, WhoeverIsThere) {
  Endpoint known = at(2);
  known.key[0] = 7;
  peer::LinkCuts cuts;
  cuts.cut(PeerId{2}, {known}, 1000);
  EXPECT_TRUE(cuts.is_cut_out(at(2)));
  EXPECT_TRUE(cuts.is_cut_out(known));
}

}  // namespace
}  // namespace padr::test
