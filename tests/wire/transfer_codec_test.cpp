#include "common/wire/transfer_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "common/sync/state_hash.h"
#include "common/sync/validation.h"
#include "tests/seed.h"
#include "tests/wire/listing.h"
#include "tests/wire/samples.h"
#include "tests/world/test_scene.h"

namespace padr::wire {
namespace {

using sync::Transfer;
using test::Played;

const Played& played() {
  static const Played kPlayed(test::seed());
  return kPlayed;
}

bool accepted(const Transfer& t) {
  return decode_transfer(encode_transfer(t), played().scene(), Played::kSlots).has_value();
}

TEST(TransferCodec, ARealStateComesBackToTheBit) {
  for (const Tick ticks : {1, Played::kComesIn + 20, Played::kIsOut + 40, 250}) {
    const Played p(test::seed(), ticks);
    const Transfer t = p.transfer();
    const Bytes bytes = encode_transfer(t);
    const auto back = decode_transfer(bytes, p.scene(), Played::kSlots);
    ASSERT_TRUE(back) << ticks;
    EXPECT_EQ(sync::hash_of(back->state), sync::hash_of(t.state)) << ticks;
    EXPECT_EQ(test::list(*back), test::list(t)) << ticks;
    EXPECT_EQ(encode_transfer(*back), bytes) << ticks;
  }
  // Or the rest proves little.
  const Transfer t = played().transfer();
  EXPECT_GT(t.state.tick, Played::kIsOut);
  EXPECT_GE(t.state.world.contacts.size(), 2U);
  EXPECT_GE(t.tail.size(), 2U);
  EXPECT_TRUE(t.state.members[3].present);
  EXPECT_FALSE(t.state.members[2].present);
}

// Also who sits in the last slot holds what it holds, and that is part of what peers compare.
TEST(TransferCodec, AllSlotsCanHoldABody) {
  Scene scene = test::busy_scene(test::seed(), 3);
  scene.avatar.spawns.assign(kMaxPeers, {1, 1});
  const sync::Fold fold(scene, kMaxPeers, 1, true);
  Transfer t;
  fold.save(t.state);
  t.slots.resize(kMaxPeers);
  t.have.resize(kMaxPeers);
  std::set<std::uint64_t> hashes;
  for (PeerId p = 0; p < kMaxPeers; ++p) {
    t.state.holds = {0, only(p), ~PeerSet{0}};
    const auto back = decode_transfer(encode_transfer(t), scene, kMaxPeers);
    ASSERT_TRUE(back) << int{p};
    EXPECT_EQ(back->state.holds, t.state.holds) << int{p};
    EXPECT_EQ(sync::hash_of(back->state), sync::hash_of(t.state)) << int{p};
    hashes.insert(sync::hash_of(t.state));
    EXPECT_FALSE(decode_transfer(encode_transfer(t), scene, kMaxPeers - 1)) << "of one slot more than there are";
  }
  EXPECT_EQ(hashes.size(), static_cast<std::size_t>(kMaxPeers));
}

// A step depends on nothing but the state: whoever is given it goes on like those who were there all along.
TEST(TransferCodec, WhoGoesOnFromATransferConfirmsTheSame) {
  Played p(test::seed(), 200);
  const auto start = decode_transfer(encode_transfer(p.transfer()), p.scene(), Played::kSlots);
  ASSERT_TRUE(start);
  sync::AgreedWorld late(p.scene(), {Played::kSlots, 0, 2, true, true, {}}, *start, {});
  EXPECT_EQ(late.confirmed_hash(), p.world().confirmed_hash());
  for (const Tick tick : {201, 230, 300, 390}) {
    p.play(tick);
    p.play(late, tick);
    ASSERT_EQ(late.confirmed().tick, p.world().confirmed().tick);
    EXPECT_EQ(late.confirmed_hash(), p.world().confirmed_hash()) << tick;
  }
  EXPECT_GT(late.confirmed().tick, 365);
}

TEST(TransferCodec, ASceneOfOtherThingsRefusesIt) {
  const Bytes bytes = encode_transfer(played().transfer());
  Scene less = played().scene();
  less.bodies.pop_back();
  Scene more = played().scene();
  more.bodies.push_back(more.bodies.back());
  EXPECT_FALSE(decode_transfer(bytes, less, Played::kSlots));
  EXPECT_FALSE(decode_transfer(bytes, more, Played::kSlots));
  EXPECT_FALSE(decode_transfer(bytes, played().scene(), Played::kSlots - 1));
  EXPECT_FALSE(decode_transfer(bytes, played().scene(), Played::kSlots + 1));
  EXPECT_FALSE(decode_transfer({}, played().scene(), Played::kSlots));
}

struct Row {
  const char* what;
  bool good;
  std::function<void(Transfer&)> spoil;
};

void expect_rows(const std::vector<Row>& rows) {
  ASSERT_TRUE(accepted(played().transfer()));
  for (const Row& r : rows) {
    Transfer t = played().transfer();
    r.spoil(t);
    EXPECT_EQ(accepted(t), r.good) << r.what;
  }
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

world::Kinematics& awake(Transfer& t) {
  t.state.world.entities[0].awake = true;
  return t.state.world.entities[0];
}
/// One that rests, whatever the session came to.
world::Kinematics& asleep(Transfer& t) {
  world::Kinematics& k = t.state.world.entities[0];
  k.velocity = {};
  k.spin = k.sleep_time = 0;
  k.awake = false;
  return k;
}

TEST(TransferCodec, EntitiesThatPhysicsCannotTakeAreRefused) {
  const Scene& scene = played().scene();
  expect_rows({
      {"an entity too few", false, [](Transfer& t) { t.state.world.entities.pop_back(); }},
      {"an entity too many", false, [](Transfer& t) { t.state.world.entities.push_back({}); }},
      {"x not a number", false, [](Transfer& t) { awake(t).position.x = kNan; }},
      {"y infinite", false, [](Transfer& t) { awake(t).position.y = -kInf; }},
      {"just inside", true, [&](Transfer& t) { awake(t).position.x = scene.upper.x + 20; }},
      {"just outside", false, [&](Transfer& t) { awake(t).position.x = scene.upper.x + 20.01F; }},
      {"angle not a number", false, [](Transfer& t) { awake(t).angle = kNan; }},
      {"largest angle", true, [](Transfer& t) { awake(t).angle = 1e5F; }},
      {"larger angle", false, [](Transfer& t) { awake(t).angle = 1.1e5F; }},
      {"as fast as may be", true,
       [](Transfer& t) {
         awake(t).velocity = {121, 0};
       }},
      {"faster", false,
       [](Transfer& t) {
         awake(t).velocity = {0, 121.1F};
       }},
      {"spins as fast as may be", true, [](Transfer& t) { awake(t).spin = -95; }},
      {"spins faster", false, [](Transfer& t) { awake(t).spin = -95.1F; }},
      {"sleep time not a number", false, [](Transfer& t) { awake(t).sleep_time = kNan; }},
      {"sleep time below 0", false, [](Transfer& t) { awake(t).sleep_time = -0.1F; }},
      {"asleep", true, [](Transfer& t) { asleep(t); }},
      {"asleep and moving", false, [](Transfer& t) { asleep(t).velocity.x = 1; }},
      {"asleep and spinning", false, [](Transfer& t) { asleep(t).spin = 1; }},
      {"asleep and falling asleep", false, [](Transfer& t) { asleep(t).sleep_time = 0.1F; }},
  });
}

world::ContactState& contact(Transfer& t) {
  return t.state.world.contacts.at(0);
}

world::ContactState::Point& one_point(Transfer& t) {
  contact(t).count = 1;
  return contact(t).points[0];
}

TEST(TransferCodec, ContactsThatAreNoneAreRefused) {
  const auto things = static_cast<std::uint32_t>(played().scene().bodies.size() + Played::kSlots);
  const auto statics = static_cast<std::uint32_t>(played().scene().statics.size());
  const auto only = [](Transfer& t, std::uint32_t first, std::uint32_t second) {
    t.state.world.contacts.resize(1);
    contact(t).key = first << 16U | second;
  };
  expect_rows({
      {"none", true, [](Transfer& t) { t.state.world.contacts.clear(); }},
      {"out of order", false, [](Transfer& t) { std::swap(t.state.world.contacts[0], t.state.world.contacts[1]); }},
      {"twice", false, [](Transfer& t) { t.state.world.contacts[1] = t.state.world.contacts[0]; }},
      {"the last two things", true, [&](Transfer& t) { only(t, things - 1, things + statics - 1); }},
      {"beyond the last", false, [&](Transfer& t) { only(t, things - 1, things + statics); }},
      {"of two fixed things", false, [&](Transfer& t) { only(t, things, things + 1); }},
      {"with itself", false, [&](Transfer& t) { only(t, 1, 1); }},
      {"the higher one first", false, [&](Transfer& t) { only(t, 2, 1); }},
      {"last type", true, [](Transfer& t) { contact(t).type = 2; }},
      {"no such type", false, [](Transfer& t) { contact(t).type = 3; }},
      {"touches at no point", true,
       [](Transfer& t) {
         contact(t).count = 0;
         contact(t).touching = true;
       }},
      {"nothing to remember", false,
       [](Transfer& t) {
         contact(t).count = 0;
         contact(t).touching = false;
       }},
      {"normal not a number", false, [](Transfer& t) { contact(t).local_normal.x = kNan; }},
      {"point infinite", false, [](Transfer& t) { contact(t).local_point.y = kInf; }},
      {"normal a little too long", true,
       [](Transfer& t) {
         contact(t).local_normal = {0, -1.001F};
       }},
      {"normal too long", false,
       [](Transfer& t) {
         contact(t).local_normal = {0, -1.1F};
       }},
      {"point far out", false, [](Transfer& t) { contact(t).local_point.x = 1.1e4F; }},
      {"pushes", true, [](Transfer& t) { one_point(t).normal_impulse = 1e9F; }},
      {"pushes too hard", false, [](Transfer& t) { one_point(t).normal_impulse = 1.1e9F; }},
      // Box2D aborts the process.
      {"pulls", false, [](Transfer& t) { one_point(t).normal_impulse = -0.1F; }},
      {"slips the other way", true, [](Transfer& t) { one_point(t).tangent_impulse = -1; }},
      {"slips too hard", false, [](Transfer& t) { one_point(t).tangent_impulse = -1.1e9F; }},
      {"touches far out", false, [](Transfer& t) { one_point(t).local.y = -1.1e4F; }},
      {"impulse not a number", false,
       [](Transfer& t) {
         contact(t).count = 2;
         contact(t).points[1].tangent_impulse = kNan;
       }},
  });
}

TEST(TransferCodec, AvatarsAndAuthorityThatNoFoldComesToAreRefused) {
  const auto avatar = [](Transfer& t) -> sync::AvatarModel& { return t.state.avatars[1]; };
  const auto member = [](Transfer& t) -> sync::Member& { return t.state.members[1]; };
  const auto body = [](Transfer& t) -> sync::Authority& { return t.state.authority[0]; };
  expect_rows({
      {"an avatar too few", false,
       [](Transfer& t) {
         t.state.avatars.pop_back();
         t.state.members.pop_back();
       }},
      {"velocity not a number", false, [&](Transfer& t) { avatar(t).velocity.x = kNan; }},
      {"too fast", false,
       [&](Transfer& t) {
         avatar(t).velocity = {121.1F, 0};
       }},
      {"control infinite", false, [&](Transfer& t) { avatar(t).control.y = kInf; }},
      {"control as far as may be", true,
       [&](Transfer& t) {
         avatar(t).control = {0, 1e4F};
       }},
      {"control farther", false,
       [&](Transfer& t) {
         avatar(t).control = {0, 1.01e4F};
       }},
      {"told at this tick", true, [&](Transfer& t) { avatar(t).since = t.state.tick; }},
      {"told later", false, [&](Transfer& t) { avatar(t).since = t.state.tick + 1; }},
      {"no member's", false, [&](Transfer& t) { member(t).present = false; }},
      {"last incarnation", true, [&](Transfer& t) { member(t).incarnation = (1U << 30U) - 1; }},
      {"and the one after", false, [&](Transfer& t) { member(t).incarnation = 1U << 30U; }},
      {"a body's owner too few", false, [](Transfer& t) { t.state.authority.pop_back(); }},
      {"a body's holds too many", false, [](Transfer& t) { t.state.holds.push_back(0); }},
      {"never claimed", true, [&](Transfer& t) { body(t) = {}; }},
      {"never claimed, and an epoch", false,
       [&](Transfer& t) {
         body(t) = {kNoPeer, true, 1, 0};
       }},
      {"never claimed, and a tick", false,
       [&](Transfer& t) {
         body(t) = {kNoPeer, true, 0, 1};
       }},
      {"never claimed, and not free", false,
       [&](Transfer& t) {
         body(t) = {kNoPeer, false, 0, 0};
       }},
      {"claimed by the last slot", true,
       [&](Transfer& t) {
         body(t) = {3, false, 1, t.state.tick};
       }},
      {"claimed by no slot", false,
       [&](Transfer& t) {
         body(t) = {4, false, 1, 0};
       }},
      {"claimed in no epoch", false,
       [&](Transfer& t) {
         body(t) = {3, false, 0, 0};
       }},
      {"claimed in the last epoch", true,
       [&](Transfer& t) {
         body(t) = {3, true, 1U << 30U, 0};
       }},
      {"and the one after", false,
       [&](Transfer& t) {
         body(t) = {3, true, (1U << 30U) + 1, 0};
       }},
      {"claimed later", false,
       [&](Transfer& t) {
         body(t) = {3, false, 1, t.state.tick + 1};
       }},
      {"held by all slots", true, [](Transfer& t) { t.state.holds[0] = 15; }},
      {"held by no slot", false, [](Transfer& t) { t.state.holds[0] = 16; }},
  });
}

TEST(TransferCodec, TicksSlotsAndTailsThatContradictThemselvesAreRefused) {
  constexpr Tick kLast = std::numeric_limits<Tick>::max() - 1;
  expect_rows({
      {"the last tick", true,
       [](Transfer& t) {
         t.state.tick = kLast;
         t.tail.clear();
       }},
      {"the tick after", false,
       [](Transfer& t) {
         t.state.tick = kLast + 1;
         t.tail.clear();
       }},
      {"a slot too few", false,
       [](Transfer& t) {
         t.slots.pop_back();
         t.have.pop_back();
       }},
      {"has what it does not", false, [](Transfer& t) { t.have[1] = t.slots[1].first - 1; }},
      {"has nothing more", true, [](Transfer& t) { t.have[1] = t.slots[1].first; }},
      {"has too many", false, [](Transfer& t) { t.have[1] = 1U << 30U; }},
      {"an update of the tick", true, [](Transfer& t) { t.tail[0].tick = t.state.tick; }},
      {"an update of before", false, [](Transfer& t) { t.tail[0].tick = t.state.tick - 1; }},
      {"updates out of order", false, [](Transfer& t) { std::swap(t.tail[0], t.tail[1]); }},
      {"two of one peer and tick", false, [](Transfer& t) { t.tail[1] = t.tail[0]; }},
      {"of no slot", false, [](Transfer& t) { t.tail.back().peer = 4; }},
      {"numbered too high", false, [](Transfer& t) { t.tail.back().index = 1U << 30U; }},
      {"64 that are gone", true, [](Transfer& t) { t.gone.resize(64, t.gone[0]); }},
      {"65 that are gone", false, [](Transfer& t) { t.gone.resize(65, t.gone[0]); }},
      {"gone from nowhere", false, [](Transfer& t) { t.gone[1].at = {}; }},
      {"gone before it came", false, [](Transfer& t) { t.gone[0].since = t.gone[0].removed + 1; }},
      {"8 proofs", true, [](Transfer& t) { t.proofs.resize(8, t.proofs[0]); }},
      {"9 proofs", false, [](Transfer& t) { t.proofs.resize(9, t.proofs[0]); }},
      {"a proof against no slot", false, [](Transfer& t) { t.proofs[0].one.peer = 4; }},
      {"a proof by an incarnation too high", false, [](Transfer& t) { t.proofs[0].incarnation = 1U << 30U; }},
      {"not a number", false,
       [](Transfer& t) {
         sync::Bundle& b = t.tail.back();
         b.avatar = sync::AvatarUpdate{};
         b.avatar->position.x = kNan;
       }},
      {"of no body", false,
       [](Transfer& t) {
         sync::BodyUpdate u;
         u.body = static_cast<EntityId>(played().scene().bodies.size());
         t.tail.back().bodies = {u};
       }},
      {"declares nobody gone", false,
       [](Transfer& t) {
         sync::Bundle& b = t.tail.back();
         b.avatar.reset();
         b.bodies.clear();
         b.removals.push_back({4, 0, 0});
       }},
  });
}

/// What physics and fold rely on, in words of their own.
bool usable(const Transfer& t) {
  const Scene& scene = played().scene();
  for (const world::Kinematics& k : t.state.world.entities)
    if (!sync::believable({k.position, k.angle, k.velocity, k.spin, k.awake}, scene)) return false;
  for (const world::ContactState& c : t.state.world.contacts) {
    if (c.count > c.points.size()) return false;
    for (std::size_t i = 0; i < c.count; ++i)
      if (!std::isfinite(c.points[i].normal_impulse) || !std::isfinite(c.points[i].tangent_impulse)) return false;
  }
  for (const sync::Authority& a : t.state.authority)
    if (a.owner != kNoPeer && a.owner >= Played::kSlots) return false;
  for (const sync::Bundle& b : t.tail)
    if (b.peer >= Played::kSlots || b.tick < t.state.tick) return false;
  const auto slots = static_cast<std::size_t>(Played::kSlots);
  return t.state.world.entities.size() == scene.bodies.size() + slots && t.state.members.size() == slots &&
         t.state.avatars.size() == slots && t.slots.size() == slots && t.have.size() == slots &&
         t.state.authority.size() == scene.bodies.size() && t.state.holds.size() == scene.bodies.size() &&
         t.state.tick >= 0;
}

TEST(TransferCodec, DamageNeverCrashesAndWhatGetsInCanBePlayed) {
  Rng rng(test::seed());
  const Bytes whole = encode_transfer(played().transfer());
  const auto size = static_cast<std::uint32_t>(whole.size());
  int in = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = whole;
    if (i % 8 == 0) bytes.resize(rng.below(size));
    for (std::uint32_t n = 1 + rng.below(3); n > 0 && !bytes.empty(); --n)
      bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<std::byte>(rng.below(256));
    const auto t = decode_transfer(bytes, played().scene(), Played::kSlots);
    if (!t) continue;
    ++in;
    ASSERT_TRUE(usable(*t)) << i;
    if (in % 10 != 0) continue;
    sync::Fold fold(played().scene(), Played::kSlots, 0, true);
    fold.restore(t->state);
    for (int k = 0; k < 5; ++k) fold.step();
    sync::FoldState s;
    fold.save(s);
    for (const world::Kinematics& e : s.world.entities) ASSERT_TRUE(is_finite(e.position)) << i;
  }
  EXPECT_GT(in, 1000) << "or nothing has been tested";
}

}  // namespace
}  // namespace padr::wire
