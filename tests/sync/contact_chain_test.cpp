#include "common/reckoning/contact_chain.h"

#include <gtest/gtest.h>

namespace padr::sync {
namespace {

constexpr EntityId kAvatar = 10;
using Ids = std::vector<EntityId>;

TEST(ContactChain, FollowsContactsFromTheAvatarThroughBodies) {
  ContactChain chain(10, kAvatar, 0);
  const ChainChanges c = chain.update({{1, 2}, {1, kAvatar}, {2, 3}, {5, 6}}, 1);
  EXPECT_EQ(c.begun, (Ids{1}));
  EXPECT_EQ(c.joined, (Ids{2, 3}));
  EXPECT_TRUE(chain.held(1));
  EXPECT_FALSE(chain.held(2));
  EXPECT_TRUE(chain.member(3));
  EXPECT_FALSE(chain.member(5));
}

TEST(ContactChain, WhenTheAvatarLeavesTheFirstBodyAllLinksEnd) {
  ContactChain chain(10, kAvatar, 0);
  chain.update({{1, 2}, {1, kAvatar}, {2, 3}}, 1);
  const ChainChanges c = chain.update({{1, 2}, {2, 3}}, 2);
  EXPECT_EQ(c.ended, (Ids{1}));
  EXPECT_EQ(c.left, (Ids{1, 2, 3}));
}

TEST(ContactChain, ALinkThatFlickersWithinThePatienceIsOneLink) {
  ContactChain chain(10, kAvatar, 3);
  chain.update({{1, kAvatar}}, 1);
  for (Tick t = 2; t <= 4; ++t) EXPECT_TRUE(chain.update({}, t).ended.empty()) << t;
  EXPECT_TRUE(chain.update({{1, kAvatar}}, 4).begun.empty());
  for (Tick t = 5; t <= 7; ++t) EXPECT_TRUE(chain.update({}, t).ended.empty()) << t;
  EXPECT_EQ(chain.update({}, 8).ended, (Ids{1}));
  EXPECT_EQ(chain.update({{1, kAvatar}}, 9).begun, (Ids{1}));
}

TEST(ContactChain, OtherAvatarsEndAPath) {
  constexpr EntityId kOther = 11;
  ContactChain chain(10, kAvatar, 0);
  const ChainChanges c = chain.update({{1, kAvatar}, {1, kOther}, {4, kOther}}, 1);
  EXPECT_EQ(c.begun, (Ids{1}));
  EXPECT_TRUE(c.joined.empty());
  EXPECT_FALSE(chain.member(4));
}

}  // namespace
}  // namespace padr::sync
