// Why something is told: every rule as a table.
#include "common/reckoning/reasons.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace padr::sync {
namespace {

Technique full() {
  Technique t;
  t.body_threshold = 0.1F;
  t.rest_state = true;
  t.end_update = true;
  return t;
}

TEST(Reasons, OfABodyThatIsOwned) {
  const OwnedBody moving{.metres = 0.05F, .ahead_metres = 0.05F, .differs = true};
  const auto with = [&](auto change) {
    OwnedBody b = moving;
    change(b);
    return b;
  };
  const auto resting = [&](auto change) {
    OwnedBody b = moving;
    b.rests = true;
    change(b);
    return b;
  };
  struct Row {
    std::string name;
    OwnedBody body;
    BodyReason reason;
  };
  const std::optional<Cause> none;
  const std::vector<Row> rows{
      {"within the threshold", moving, {none, false}},
      {"off by more", with([](OwnedBody& b) { b.metres = 0.11F; }), {Cause::kBodyThreshold, false}},
      {"will be off by more", with([](OwnedBody& b) { b.ahead_metres = 0.11F; }), {Cause::kBodyThreshold, false}},
      {"rests elsewhere", resting([](OwnedBody&) {}), {Cause::kAtRest, true}},
      {"rests where it is believed", resting([](OwnedBody& b) { b.differs = false; }), {none, true}},
      {"rests, off by more", resting([](OwnedBody& b) { b.metres = 0.11F; }), {Cause::kAtRest, true}},
      {"rests, but not all know the claim", resting([](OwnedBody& b) { b.claim_is_known = false; }), {none, false}},
      {"the same, off by more",
       resting([](OwnedBody& b) {
         b.claim_is_known = false;
         b.metres = 0.11F;
       }),
       {Cause::kBodyThreshold, false}},
      {"rests under the avatar, told of lately",
       resting([](OwnedBody& b) {
         b.held = true;
         b.since_rest_told = kRestAgainTicks - 1;
       }),
       {none, false}},
      {"rests under the avatar, told of long ago",
       resting([](OwnedBody& b) {
         b.held = true;
         b.since_rest_told = kRestAgainTicks;
       }),
       {Cause::kAtRest, false}},
  };
  for (const Row& r : rows) EXPECT_EQ(reason_of(r.body, full()), r.reason) << r.name;

  Technique everything = full();
  everything.every_tick = true;
  EXPECT_EQ(reason_of(moving, everything), (BodyReason{Cause::kBodyThreshold, false}));
  EXPECT_EQ(reason_of(resting([](OwnedBody& b) { b.awake = false; }), everything), (BodyReason{Cause::kAtRest, true}));
  Technique no_threshold = full();
  no_threshold.body_threshold = 0;
  EXPECT_EQ(reason_of(with([](OwnedBody& b) { b.metres = 9; }), no_threshold), BodyReason{});
  Technique no_rest = full();
  no_rest.rest_state = false;
  EXPECT_EQ(reason_of(resting([](OwnedBody&) {}), no_rest), (BodyReason{none, true}));
}

TEST(Reasons, OfTheAvatar) {
  const auto with = [](auto change) {
    OwnAvatar a;
    change(a);
    return a;
  };
  const auto still = [](auto change) {  // for long, and nothing wrong
    OwnAvatar a;
    a.steady = a.stands = a.undriven = a.since_settled = a.since_rest = 10 * kRestAgainTicks;
    a.awake = false;
    change(a);
    return a;
  };
  struct Row {
    std::string name;
    OwnAvatar avatar;
    AvatarReason reason;
  };
  const AvatarReason nothing;
  const AvatarReason threshold{Cause::kThreshold, false, false};
  const AvatarReason settled{Cause::kAtRest, false, false};
  const AvatarReason exact{Cause::kAtRest, true, false};
  const AvatarReason asleep{Cause::kAtRest, false, true};
  const std::vector<Row> rows{
      {"moves as its model does", with([](OwnAvatar&) {}), nothing},
      {"its model is off", with([](OwnAvatar& a) { a.off = true; }), threshold},
      {"nobody knows of it", with([](OwnAvatar& a) { a.present = false; }), threshold},
      {"misplaced, but the input changes", with([](OwnAvatar& a) { a.misplaced = true; }), nothing},
      {"nothing has been wrong for long", still([](OwnAvatar&) {}), nothing},
      {"the input is steady, and the model drives elsewhere", with([](OwnAvatar& a) {
         a.steady = a.since_settled = kSettledTicks;
         a.misdriven = true;
       }),
       settled},
      {"the same, told of lately", with([](OwnAvatar& a) {
         a.steady = kSettledTicks;
         a.since_settled = kSettledTicks - 1;
         a.misdriven = true;
       }),
       nothing},
      {"all still, and something differs in a bit", still([](OwnAvatar& a) { a.any_differs = true; }), exact},
      {"the same, but the input has just become steady", still([](OwnAvatar& a) {
         a.any_differs = true;
         a.steady = kSettledTicks - 1;
       }),
       nothing},
      {"asleep here, awake for the others", still([](OwnAvatar& a) { a.differs = true; }), asleep},
      {"awake, but nothing drives it", still([](OwnAvatar& a) { a.awake = true; }), asleep},
      {"the same, told of lately", still([](OwnAvatar& a) {
         a.awake = true;
         a.since_rest = kRestAgainTicks - 1;
       }),
       nothing},
  };
  Technique by_input = full();
  by_input.model = Model::kInput;
  for (const Row& r : rows) EXPECT_EQ(reason_of(r.avatar, by_input), r.reason) << r.name;

  Technique by_speed = full();
  by_speed.model = Model::kFirst;
  EXPECT_EQ(reason_of(still([](OwnAvatar& a) { a.any_differs = a.misdriven = true; }), by_speed), nothing)
      << "a model without input cannot be driven elsewhere";
  by_speed.every_tick = true;
  EXPECT_EQ(reason_of(with([](OwnAvatar&) {}), by_speed), threshold);
}

TEST(Reasons, OfContactsAndProxies) {
  Technique t = full();
  EXPECT_FALSE(tells_end_state(t, 0.004F));
  EXPECT_TRUE(tells_end_state(t, 0.006F));
  t.update_every_contact = true;
  EXPECT_TRUE(tells_end_state(t, 0));
  t.end_update = false;
  EXPECT_FALSE(tells_end_state(t, 1));

  world::Kinematics believed{};
  believed.position = {1, 1};
  believed.velocity = {2, 0};
  EXPECT_FALSE(is_missed_collision({1.009F, 1}, {2.29F, 0}, believed));
  EXPECT_TRUE(is_missed_collision({1.011F, 1}, {2, 0}, believed));
  EXPECT_TRUE(is_missed_collision({1, 1}, {1.69F, 0}, believed));
  EXPECT_TRUE(is_still({{5, 5}, 1, {0.009F, 0}, 0.03F, true}));
  EXPECT_FALSE(is_still({{5, 5}, 1, {0.011F, 0}, 0, true}));
  EXPECT_FALSE(is_still({{5, 5}, 1, {0, 0}, -0.04F, true}));
}

}  // namespace
}  // namespace padr::sync
