// Bodies that come into a region and go out of it: what the agreed world makes of entries and exits.
#include <gtest/gtest.h>

#include "common/crowd/regions.h"
#include "common/sync/fold.h"
#include "common/sync/state_hash.h"
#include "common/sync/validation.h"

namespace padr::sync {
namespace {

constexpr crowd::Region kHere{0, 0};
const BodyName kStranger{12345, 7};

Passage entry(std::uint32_t crossings, Vec2 at = {4, 4}, std::uint8_t build = 1) {
  Passage p;
  p.kind = Passage::Kind::kIn;
  p.name = kStranger;
  p.crossings = crossings;
  p.build = build;
  p.state.position = at;
  p.state.velocity = {1, 0};
  return p;
}

Passage exit_of(BodyName name, std::uint32_t crossings) {
  Passage p;
  p.kind = Passage::Kind::kOut;
  p.name = name;
  p.crossings = crossings;
  return p;
}

/// Peer 0 of two says so, now.
class Region : public ::testing::Test {
 protected:
  void say(const Passage& p) {
    Bundle b;
    b.peer = 0;
    b.tick = fold.tick();
    b.index = static_cast<std::uint32_t>(b.tick);
    b.passages = {p};
    fold.apply(b);
    fold.step();
  }
  const crowd::Plane plane{};
  const Scene scene = crowd::scene_of(plane, kHere);
  Fold fold{scene, plane.slots, 2, true};
};

TEST_F(Region, AnEntryTakesTheLowestEmptySlotOfItsBuild) {
  EXPECT_FALSE(fold.residents().find(kStranger));
  say(entry(1));
  const auto b = fold.residents().find(kStranger);
  ASSERT_TRUE(b);
  EXPECT_EQ(*b, plane.bodies + 1);  // builds go round: 0 1 2 0 1 2 ...
  EXPECT_EQ(scene.region->builds[*b], 1);
  EXPECT_TRUE(fold.world().present(*b));
  EXPECT_GT(fold.world().position(*b).x, 4);  // it moves on from where it was
}

TEST_F(Region, SaidTwiceItCountsOnce) {
  say(entry(1));
  const EntityId b = *fold.residents().find(kStranger);
  const Vec2 there = fold.world().position(b);
  say(entry(1, {9, 9}));
  EXPECT_LT(distance(fold.world().position(b), there), 0.1F);
  int present = 0;
  for (const Resident& r : fold.residents().slots) present += r.present ? 1 : 0;
  EXPECT_EQ(present, plane.bodies + 1);
}

TEST_F(Region, WhoComesBackBeforeItWasGoneIsTheNewOne) {
  say(entry(1));
  say(entry(3, {9, 9}));
  const EntityId b = *fold.residents().find(kStranger);
  EXPECT_EQ(fold.residents().slots[b].crossings, 3U);
  EXPECT_NEAR(fold.world().position(b).y, 9, 0.1);
}

TEST_F(Region, AnExitEmptiesTheSlotUnlessItIsOlderThanWhatIsThere) {
  say(entry(2));
  say(exit_of(kStranger, 2));
  EXPECT_TRUE(fold.residents().find(kStranger)) << "it went out before it came in";
  const EntityId b = *fold.residents().find(kStranger);
  say(exit_of(kStranger, 3));
  EXPECT_FALSE(fold.residents().find(kStranger));
  EXPECT_FALSE(fold.world().present(b));
  EXPECT_EQ(fold.residents().slots[b], Resident{});
}

TEST_F(Region, WhatHasGoneOutIsNotBroughtBackByALateEntry) {
  say(entry(1));
  say(exit_of(kStranger, 2));
  say(entry(1));
  EXPECT_FALSE(fold.residents().find(kStranger));
  say(entry(3));
  EXPECT_TRUE(fold.residents().find(kStranger));
}

TEST_F(Region, TheFirstWordOnWhereItIsBoundCounts) {
  Passage bound;
  bound.name = {crowd::id_of(kHere), 3};
  bound.to = crowd::id_of({1, 0});
  say(bound);
  bound.to = crowd::id_of({0, 1});
  say(bound);
  EXPECT_EQ(fold.residents().slots[3].bound, crowd::id_of({1, 0}));
  say(exit_of(bound.name, 1));
  EXPECT_EQ(fold.residents().slots[3], Resident{});
  bound.name = kStranger;
  bound.crossings = 1;
  say(entry(1));
  say(bound);
  EXPECT_EQ(fold.residents().slots[*fold.residents().find(kStranger)].bound, 0U) << "said of it before it came in";
}

// It was bound for here when it crossed the border, and pushed to the far side of where it came from before anybody was
// in both regions. Once that was no believable place: nobody took the entry, nor anything else that its sender said
// from then on.
TEST_F(Region, WhatComesInMayLieOnTheFarSideOfTheRegionItComesFrom) {
  const auto taken = [this](Vec2 at) {
    Bundle b;
    b.peer = 1;
    b.passages.push_back(entry(1, at));
    return admit(b, scene, 4) == DropReason::kNone;
  };
  EXPECT_TRUE(taken({plane.side + 20.5F, 4}));
  EXPECT_TRUE(taken({2 * plane.side + 15, -plane.side - 15}));
  EXPECT_FALSE(taken({3 * plane.side + 21, 4}));
}

TEST_F(Region, WithoutRoomNothingComesIn) {
  const int rooms = plane.spare / 3;
  for (int i = 0; i <= rooms; ++i) {
    Passage p = entry(1, {2 + static_cast<float>(i), 2});
    p.name.number = static_cast<std::uint16_t>(i);
    say(p);
    EXPECT_EQ(fold.residents().find(p.name).has_value(), i < rooms) << i;
  }
}

TEST_F(Region, TheSenderMayGoOnOwningIt) {
  Passage p = entry(1);
  p.owned = true;
  say(p);
  EXPECT_EQ(fold.authority()[*fold.residents().find(kStranger)].holder(), 0);
  say(exit_of(kStranger, 2));
  p.crossings = 3;
  p.owned = false;
  say(p);
  const Authority& a = fold.authority()[*fold.residents().find(kStranger)];
  EXPECT_EQ(a.holder(), kNoPeer);
  EXPECT_EQ(a.epoch, 2U) << "no word on who was there before counts";
}

TEST_F(Region, WhoIsWhereIsInTheHashAndSurvivesARestore) {
  FoldState before;
  fold.save(before);
  say(entry(1));
  say(exit_of({crowd::id_of(kHere), 0}, 1));
  FoldState after;
  fold.save(after);
  FoldState other = after;
  other.residents.gone.clear();
  EXPECT_NE(hash_of(after), hash_of(other));
  Fold second(scene, plane.slots, 0, true);
  second.restore(after);
  for (int t = 0; t < 60; ++t) {
    fold.step();
    second.step();
  }
  FoldState a;
  FoldState b;
  fold.save(a);
  second.save(b);
  EXPECT_EQ(hash_of(a), hash_of(b));
  fold.restore(before);
  FoldState again;
  fold.save(again);
  EXPECT_EQ(hash_of(before), hash_of(again));
}

TEST_F(Region, AnAvatarIsThereOnceItsOwnerHasSaidWhere) {
  Bundle order;
  order.peer = 0;
  order.tick = fold.tick();
  Admission& a = order.admission.emplace();
  a.slot = 5;
  fold.apply(order);
  EXPECT_TRUE(fold.members()[5].present);
  EXPECT_FALSE(fold.world().present(fold.world().avatar(5)));
  Bundle word;
  word.peer = 5;
  word.tick = fold.tick();
  word.avatar.emplace().position = {7, 7};
  fold.apply(word);
  EXPECT_TRUE(fold.world().present(fold.world().avatar(5)));
  EXPECT_EQ(fold.world().position(fold.world().avatar(5)), (Vec2{7, 7}));
}

TEST(AdmitPassages, Table) {
  const crowd::Plane plane{};
  const Scene scene = crowd::scene_of(plane, kHere);
  const auto judge = [&](const Passage& p, const Scene& s) {
    Bundle b;
    b.passages = {p};
    return admit(b, s, plane.slots);
  };
  EXPECT_EQ(judge(entry(1), scene), DropReason::kNone);
  EXPECT_EQ(judge(entry(0), scene), DropReason::kValue) << "nothing crosses for the zeroth time";
  EXPECT_EQ(judge(entry(1U << 30U), scene), DropReason::kValue);
  EXPECT_EQ(judge(entry(1, {4, 4}, 3), scene), DropReason::kValue) << "no such build";
  EXPECT_EQ(judge(entry(1, {-67, 4}), scene), DropReason::kNone);
  EXPECT_EQ(judge(entry(1, {-69, 4}), scene), DropReason::kValue);
  EXPECT_EQ(judge(exit_of(kStranger, 1), scene), DropReason::kNone);
  Passage bound;
  bound.name = kStranger;
  EXPECT_EQ(judge(bound, scene), DropReason::kValue) << "bound for nowhere";
  bound.to = crowd::id_of(kHere);
  EXPECT_EQ(judge(bound, scene), DropReason::kValue) << "bound for where it is";
  bound.to = crowd::id_of({0, 1});
  EXPECT_EQ(judge(bound, scene), DropReason::kNone);
  Scene plain = scene;
  plain.region.reset();
  EXPECT_EQ(judge(exit_of(kStranger, 1), plain), DropReason::kValue) << "no region, no borders";
}

}  // namespace
}  // namespace padr::sync
