// A member that lies about what it sees: what nobody can compute with, what is not its to say, and what is not yet.
#include <iterator>
#include <map>

#include "tests/hostile/liar.h"

namespace padr::test {
namespace {

using sync::DropReason;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// An update of the liar's, of the packet's tick, in place of any that is in it.
sync::Bundle& say(sync::StatePacket& p, PeerId self) {
  if (p.updates.empty()) {
    sync::Bundle b;
    b.peer = self;
    b.tick = p.mark_tick;
    b.index = p.mark_count++;
    p.updates.push_back(b);
  }
  return p.updates.back();
}

struct Case {
  const char* name;
  DropReason why;
  std::function<void(sync::StatePacket&, PeerId self)> lie;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> kCases{
      {"NotANumber", DropReason::kValue,
       [](sync::StatePacket& p, PeerId self) {
         say(p, self).avatar = avatar_at({kNan, 1});
       }},
      {"OutsideTheWorld", DropReason::kValue,
       [](sync::StatePacket& p, PeerId self) {
         say(p, self).avatar = avatar_at({1e6F, 1});
       }},
      {"FasterThanAnything", DropReason::kValue,
       [](sync::StatePacket& p, PeerId self) {
         say(p, self).avatar = avatar_at({1, 1}, {500, 0});
       }},
      {"EpochAtTheMaximum", DropReason::kValue,
       [](sync::StatePacket& p, PeerId self) {
         sync::Bundle& b = say(p, self);
         sync::BodyUpdate u;
         u.has_state = true;
         u.epoch = 1U << 30U;
         u.claimed = b.tick;
         u.state.position = {5, 5};
         b.bodies = {u};
       }},
      {"NoSuchBody", DropReason::kEntity,
       [](sync::StatePacket& p, PeerId self) {
         sync::BodyUpdate u;
         u.body = 5000;
         say(p, self).bodies = {u};
       }},
      {"FromTheFuture", DropReason::kTick, [](sync::StatePacket& p, PeerId) { p.mark_tick += 1000; }},
  };
  return kCases;
}

class Lies : public testing::TestWithParam<std::tuple<std::size_t, int>> {};

TEST_P(Lies, HarmNobody) {
  const Case& c = cases()[std::get<0>(GetParam())];
  const auto who = static_cast<PeerId>(std::get<1>(GetParam()));
  Trial t(4, who, wire::SealMode::kAuth, 100 + std::get<0>(GetParam()));
  // What it has said before stays as it was: said twice, it would be proof by itself.
  const Tick since = t.replica(who).now();
  t.liar().begin([&](sync::StatePacket& p, PeerId) {
    std::erase_if(p.updates, [since](const sync::Bundle& b) { return b.tick <= since; });
    c.lie(p, who);
  });
  t.party().run(16);
  for (const PeerId p : t.honest()) EXPECT_GE(t.dropped(p, c.why), 10U) << p << "\n" << t.party().story();
  EXPECT_TRUE(t.liar_was_out()) << t.party().story();
  t.expect_no_harm();
}

std::string case_name(const testing::TestParamInfo<std::tuple<std::size_t, int>>& info) {
  return std::string(cases()[std::get<0>(info.param)].name) + (std::get<1>(info.param) == 0 ? "ByTheCoordinator" : "");
}

INSTANTIATE_TEST_SUITE_P(Each, Lies,
                         testing::Combine(testing::Range(std::size_t{0}, cases().size()), testing::Values(0, 2)),
                         case_name);

// Its updates are its own only: what it signs in another's name is nobody's.
TEST(Lying, WhatIsNotSignedByItsSayerIsDropped) {
  Trial t(4, 2, wire::SealMode::kAuth, 120);
  t.liar().signs = false;
  t.liar().begin([](sync::StatePacket& p, PeerId) {
    for (sync::Bundle& b : p.updates)
      if (b.avatar) b.avatar->position.x += 0.5F;
  });
  t.party().net().attract(Vec2{10, 7});
  t.party().run(16);
  EXPECT_GE(t.dropped(0, DropReason::kSignature), 10U) << t.party().story();
  EXPECT_TRUE(t.noted("signature")) << t.party().story();
  t.expect_no_harm();
}

// Another's number in the header: the address and the key say who it is.
TEST(Lying, NobodySpeaksInAnothersName) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 121);
    t.liar().send_too([](const wire::Header& h, PeerId) {
      wire::Header other = h;
      other.sender = 1;
      sync::StatePacket p;
      p.seq = 1'000'000;
      p.mark_tick = 600;
      p.mark_count = 100'000;
      return std::vector<wire::Bytes>{wire::seal(other, wire::encode(p))};
    });
    t.party().run(5);
    EXPECT_FALSE(t.liar_is_out()) << "it is harmless\n" << t.party().story();
    t.expect_no_harm();
  }
}

// Where it says it is, within what its avatar may do, is its own affair; but nobody's confirmed world depends on more
// than what it says to all.
TEST(Lying, TeleportsAreItsOwnAvatars) {
  Trial t(4, 2, wire::SealMode::kAuth, 122);
  Rng rng(122);
  std::map<std::uint32_t, Vec2> said;
  t.liar().begin([&](sync::StatePacket& p, PeerId) {
    for (sync::Bundle& b : p.updates) {
      if (!b.avatar) continue;
      const auto [at, fresh] = said.try_emplace(b.index, Vec2{});
      if (fresh) at->second = {static_cast<float>(rng.uniform(1, 15)), static_cast<float>(rng.uniform(1, 10))};
      b.avatar->position = at->second;
    }
  });
  t.party().run(10);
  t.expect_no_harm();
}

// Once, whoever had a higher number than somebody who told of another confirmed world began anew, though the
// coordinator had the same as itself.
TEST(Lying, AHashThatIsNoneMakesNobodyBeginAnew) {
  Trial t(4, 1, wire::SealMode::kAuth, 124);
  t.liar().begin([](sync::StatePacket& p, PeerId) { p.check_hash ^= p.check_tick < 0 ? 0U : 2U; });
  t.party().run(10);
  for (const PeerId p : t.honest()) EXPECT_GT(t.replica(p).stats().hash_mismatches, 0U) << p;
  t.expect_no_harm();
}

// Once, all others took its world over again and again. It may lie to one of them only.
TEST(Lying, ACoordinatorWhoseHashesAreNoneMakesNobodyBeginAnewTwice) {
  for (const bool to_all : {true, false}) {
    SCOPED_TRACE(to_all ? "to all" : "to one");
    Trial t(4, 0, wire::SealMode::kAuth, 126);
    t.liar().begin([&](sync::StatePacket& p, PeerId to) {
      if (p.check_tick >= 0 && (to_all || to == 1)) p.check_hash ^= 2U;
    });
    t.party().run(90);
    for (int person = 1; person < 4; ++person) {
      const node::Participant& peer = t.party().net().peer(person);
      EXPECT_TRUE(peer.playing() && !peer.returning()) << person << "\n" << t.party().story();
      EXPECT_EQ(peer.incarnation(), to_all || person == 1 ? 1 : 0) << person << "\n" << t.party().story();
    }
    EXPECT_EQ(t.party().judge().violation(), "") << t.party().story();
  }
}

// Its link seems to carry next to nothing: what the others have to say waits for it, but for a second at most.
TEST(Lying, WhoSaysThatAllComesLateHoldsNobodyBackForLong) {
  Trial t(4, 2, wire::SealMode::kAuth, 130);
  const Tick since = t.replica(2).now();
  std::map<PeerId, std::map<Tick, std::uint32_t>> seen;
  t.liar().begin([&](sync::StatePacket& p, PeerId to) {
    auto& by_tick = seen[to];
    by_tick[p.mark_tick] = p.seen_seq;
    const auto then = by_tick.upper_bound(since + (p.mark_tick - since) / 4);
    if (then == by_tick.begin()) return;
    p.seen_seq = std::prev(then)->second;
    p.seen_age = 0;
  });
  t.party().run(10);
  const std::uint64_t before = t.replica(1).stats().bundles;
  for (int i = 0; i < 20; ++i) {
    t.party().net().attract(i % 2 == 0 ? Vec2{4, 4} : Vec2{15, 10});
    t.party().run(1);
  }
  EXPECT_GE(t.replica(1).stats().bundles - before, 15U);
  t.expect_no_harm();
}

// Once, the others dropped what it rested on such claims as nonsense, and barred it for good.
TEST(Lying, WhoIsLedToBelieveInHighEpochsIsNotCutOff) {
  Trial t(4, 2, wire::SealMode::kAuth, 125);
  t.party().net().attract(Vec2{10, 7});
  t.liar().begin([&t](sync::StatePacket& p, PeerId to) {
    if (to != 1) return;
    for (sync::Bundle& b : p.updates) {
      b.bodies.clear();
      for (EntityId body = 0; body < 12; ++body) {
        sync::BodyUpdate u;
        u.body = body;
        u.has_state = true;
        u.epoch = t.replica(1).agreed().confirmed().authority[body].epoch + 100;
        u.claimed = b.tick;
        u.state.position = {9.0F + 0.1F * static_cast<float>(body), 7};
        u.state.awake = true;
        b.bodies.push_back(u);
      }
    }
  });
  t.party().run(8);
  EXPECT_GT(t.liar().told, 0U);
  t.liar().stop();
  t.party().run(20);
  for (const PeerId p : t.honest())
    EXPECT_FALSE(t.party().noted(t.person(p), "peer 1 keeps sending invalid datagrams")) << t.party().story();
  EXPECT_TRUE(t.party().net().peer(t.person(1)).playing()) << t.party().story();
  EXPECT_EQ(t.replica(0).link(1).cut_offs, 0U) << t.party().story();
}

// Once, it was evicted after 3 s, as the others dropped all that it sent, and came back to the same coordinator each
// time.
TEST(Lying, WhoIsToldAWrongTimeLearnsItFromTheOthers) {
  Trial t(4, 0, wire::SealMode::kAuth, 131);
  ASSERT_EQ(t.party().net().peer(t.person(1)).coordinator(), 0);
  t.liar().speak_to_joiners([](wire::SessionMessage& m) {
    if (auto* pong = std::get_if<wire::Pong>(&m)) pong->session += 3 * kMicrosPerSecond;
  });
  const int joiner = t.party().net().start(t.person(1));
  EXPECT_TRUE(t.party().run_until(10, [&] { return t.noted("clock is 2.9 s ahead") && t.party().united(); }))
      << t.party().story();
  EXPECT_EQ(t.party().net().peer(joiner).incarnation(), 1) << t.party().story();
  EXPECT_NEAR(t.party().replica(joiner).now(), t.replica(1).now(), 6);
  t.expect_no_harm();
  EXPECT_EQ(t.party().net().peer(joiner).incarnation(), 1) << t.party().story();
}

// Once, it came in with the time that it was told, was declared gone, and so on until the others had told it otherwise.
TEST(Lying, WhoHasHadTheSessionsTimeIsToldNoOther) {
  Trial t(4, 0, wire::SealMode::kAuth, 133);
  t.liar().speak_to_joiners([](wire::SessionMessage& m) {
    if (auto* pong = std::get_if<wire::Pong>(&m)) pong->session += 3 * kMicrosPerSecond;
  });
  const auto cut = [&t](bool is) {
    for (PeerId p = 0; p < 3; ++p) {
      t.party().net().cut(t.person(p), t.person(3), is);
      t.party().net().cut(t.person(3), t.person(p), is);
    }
  };
  cut(true);
  t.party().run(6);
  cut(false);
  EXPECT_TRUE(t.party().run_until(10, [&] { return t.party().united(); })) << t.party().story();
  t.party().run(4);
  EXPECT_FALSE(t.noted("clock is")) << t.party().story();
  EXPECT_EQ(t.party().net().peer(t.person(3)).incarnation(), 1) << t.party().story();
  EXPECT_NEAR(t.replica(3).now(), t.replica(1).now(), 6);
}

// Once, nobody could join any more, nor after the liar had left, as a world with something so far out was refused.
TEST(Lying, WhoLeavesTheWorldClosesItToNobody) {
  Trial t(4, 2, wire::SealMode::kAuth, 777);
  t.liar().begin([](sync::StatePacket& p, PeerId self) {
    sync::AvatarUpdate& away = say(p, self).avatar.emplace();
    away.model = Model::kFirst;
    away.position = {39.5F, 7.5F};
    away.velocity = {100, 0};
  });
  t.party().run(5);
  const int newcomer = t.party().net().start(0);
  const auto took = t.party().run_until(5, [&] { return t.party().net().peer(newcomer).playing(); });
  ASSERT_TRUE(took.has_value()) << t.party().story();
  const world::Snapshot& world = t.replica(0).agreed().confirmed().world;
  const std::size_t avatar = world.entities.size() - t.replica(0).roster().seats.size() + 2;
  EXPECT_GT(world.entities[avatar].position.x, 38) << "or there was no lie";
}

// Nothing prevents it, as each signs what it says; but it shows, and whoever has been told otherwise than the
// coordinator begins anew.
TEST(Lying, WhoIsToldOtherThingsThanTheRestNoticesAndIsMended) {
  Trial t(4, 2, wire::SealMode::kAuth, 123);
  t.liar().begin([](sync::StatePacket& p, PeerId to) {
    for (sync::Bundle& b : p.updates)
      if (b.avatar && to == 1) b.avatar->position.x += 0.5F;
  });
  t.party().net().attract(Vec2{10, 7});
  t.party().run(8);
  EXPECT_TRUE(t.noted("CONFIRMED WORLDS DIFFER")) << t.party().story();
  t.liar().stop();
  t.party().run(30);
  Tick all = t.replica(0).agreed().confirmed().tick;
  for (const PeerId p : t.honest()) all = std::min(all, t.replica(p).agreed().confirmed().tick);
  EXPECT_GT(all, 40 * kTicksPerSecond);
  for (const PeerId p : t.honest()) {
    const sync::FoldState* theirs = t.replica(p).agreed().confirmed_at(all);
    ASSERT_NE(theirs, nullptr);
    EXPECT_EQ(sync::hash_of(*theirs), sync::hash_of(*t.replica(0).agreed().confirmed_at(all))) << t.party().story();
    // A third one may have been given such an update by peer 1, once the liar was gone.
    if (p > 1) continue;
    EXPECT_EQ(t.party().net().peer(t.person(p)).incarnation() > 0, p == 1) << t.party().story();
  }
}

}  // namespace
}  // namespace padr::test
