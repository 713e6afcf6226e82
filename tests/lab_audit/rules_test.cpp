// The rules by themselves, on both sides of every limit.
#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "tools/lab/audit/avatar_rule.h"
#include "tools/lab/audit/body_rule.h"
#include "tools/lab/audit/hash_record.h"
#include "tools/lab/audit/margins.h"
#include "tools/lab/audit/reach.h"

namespace padr::lab::audit {
namespace {

const Scene& arena() {
  static const Scene kScene = scenarios::load_embedded("arena", 1);
  return kScene;
}

const Limits& limits() {
  static const Limits kLimits(arena(), 4);
  return kLimits;
}

std::vector<Kind> exceeded(const std::vector<Measure>& all) {
  std::vector<Kind> kinds;
  for (const Measure& m : all)
    if (m.exceeds()) kinds.push_back(m.kind);
  return kinds;
}

using Kinds = std::vector<Kind>;

/// From (5, 5) at 3 m/s to the right.
AvatarCase after(Tick ticks, Vec2 position, Vec2 velocity) {
  return {{100, {5, 5}, {3, 0}}, {100 + ticks, position, velocity}, false, false, false, 0, 0};
}

TEST(AvatarRule, SpeedInTheOpenIsThatOfTheScene) {
  EXPECT_EQ(exceeded(judge(limits(), after(60, {8, 5}, {6.1F, 0}))), Kinds{});
  EXPECT_EQ(exceeded(judge(limits(), after(60, {8, 5}, {6.3F, 0}))), Kinds{Kind::kAvatarSpeed});
}

TEST(AvatarRule, AccelerationInTheOpenIsForceByMass) {
  EXPECT_EQ(exceeded(judge(limits(), after(3, {5.2F, 5}, {4, 0}))), Kinds{});
  EXPECT_EQ(exceeded(judge(limits(), after(3, {5.2F, 5}, {4.3F, 0}))), Kinds{Kind::kAvatarAcceleration});
  AvatarCase at_wall = after(3, {5.2F, 5}, {-3, 0});
  at_wall.obstacle = true;
  EXPECT_EQ(exceeded(judge(limits(), at_wall)), Kinds{}) << "a wall turns it round";
}

TEST(AvatarRule, WayIsSpeedByTime) {
  EXPECT_EQ(exceeded(judge(limits(), after(60, {11.1F, 5}, {3, 0}))), Kinds{});
  EXPECT_EQ(exceeded(judge(limits(), after(60, {11.3F, 5}, {3, 0}))), Kinds{Kind::kAvatarWay});
}

TEST(AvatarRule, ContactsGiveWhatTheOtherThingHas) {
  AvatarCase hit = after(60, {8, 5}, {9, 0});
  hit.avatar = true;
  hit.avatars = 6;
  EXPECT_EQ(exceeded(judge(limits(), hit)), (Kinds{Kind::kAvatarSpeed}));
  hit.avatars = 30;
  EXPECT_EQ(exceeded(judge(limits(), hit)), Kinds{}) << "somebody led it to believe in that";
}

TEST(AvatarRule, WhoWasTooFastBrakes) {
  AvatarCase c = after(6, {6, 5}, {8, 0});
  c.before.velocity = {10, 0};
  EXPECT_EQ(exceeded(judge(limits(), c)), Kinds{}) << "2 m/s less after 0.1 s";
  c.now.velocity = {8.3F, 0};
  EXPECT_EQ(exceeded(judge(limits(), c)), Kinds{Kind::kAvatarSpeed});
}

TEST(AvatarRule, WaysAddUp) {
  EXPECT_FALSE(judge_way(limits(), 16, 2, 6, 6).exceeds());
  EXPECT_TRUE(judge_way(limits(), 17, 2, 6, 6).exceeds());
}

BodyCase body(Vec2 velocity, Vec2 position = {5, 5}) {
  BodyCase c;
  c.state.position = position;
  c.state.velocity = velocity;
  return c;
}

TEST(BodyRule, SpeedIsWhatContactsGive) {
  EXPECT_EQ(exceeded(judge(limits(), body({10, 0}))), Kinds{});
  EXPECT_EQ(exceeded(judge(limits(), body({13, 0}))), Kinds{Kind::kBodySpeed});
  BodyCase hit = body({13, 0});
  hit.fastest = 10;
  EXPECT_EQ(exceeded(judge(limits(), hit)), Kinds{});
  BodyCase pushed = body({60, 0});
  pushed.pushed = true;
  EXPECT_EQ(exceeded(judge(limits(), pushed)), Kinds{});
}

TEST(BodyRule, WayUnderOneAuthority) {
  BodyCase c = body({}, {11, 5});
  c.before = {{5, 5}, 0.5F};
  EXPECT_EQ(exceeded(judge(limits(), c)), Kinds{});
  c.before = {{5, 5}, 0.1F};
  EXPECT_EQ(exceeded(judge(limits(), c)), Kinds{Kind::kBodyWay});
}

TEST(BodyRule, JumpFromWhereItLay) {
  BodyCase c = body({}, {9, 5});
  c.lay_at = Vec2{5, 5};
  c.jump = kJump;
  EXPECT_EQ(exceeded(judge(limits(), c)), Kinds{Kind::kBodyJump});
  c.jump = kJumpAlone;
  EXPECT_EQ(exceeded(judge(limits(), c)), Kinds{});
}

// Nobody has stirred anything: only the member's own things count.
TEST(Claims, AreReachedByTheAvatarOrByAChain) {
  const Surroundings nothing(limits(), static_cast<int>(arena().bodies.size()), 4);
  const auto avatar = static_cast<EntityId>(arena().bodies.size());
  const std::vector<Place> own{{avatar, {5, 5}, 0.25F}};
  const std::vector<Place> claims{{0, {5.8F, 5}, 0.25F}, {1, {7, 5}, 0.25F}, {2, {14, 5}, 0.25F}};
  const std::vector<Measure> all = judge_claims(limits(), nothing, own, claims);
  EXPECT_EQ(all[0].measured, 0);
  EXPECT_FALSE(all[1].exceeds()) << "through body 0";
  EXPECT_TRUE(all[2].exceeds());
  EXPECT_LT(all[1].measured, judge_claims(limits(), nothing, own, {claims[1]})[0].measured) << "not without it";
}

TEST(Hashes, TellWhatAMemberKnewAndAgreedTo) {
  HashRecord r;
  const HashRecord::Sitter who{1, 0};
  for (Tick t = 0; t <= 120; ++t) r.confirmed(t, 0x1000U + static_cast<unsigned>(t));
  r.told(who, 70, 30, (0x1000U + 30) | 1U);
  r.told(who, 130, 90, 5);
  EXPECT_EQ(r.confirmed_by(who, 69), -1);
  EXPECT_EQ(r.confirmed_by(who, 70), 30);
  EXPECT_EQ(r.confirmed_by(who, 200), 90);
  EXPECT_EQ(r.before(who, 89), HashRecord::Verdict::kSame);
  EXPECT_EQ(r.before(who, 90), HashRecord::Verdict::kDiffers);
  EXPECT_EQ(r.after(who, 40), HashRecord::Verdict::kDiffers);
  EXPECT_EQ(r.after(who, 90), HashRecord::Verdict::kUnknown);
  EXPECT_EQ(r.before({2, 0}, 90), HashRecord::Verdict::kUnknown);
}

}  // namespace
}  // namespace padr::lab::audit
