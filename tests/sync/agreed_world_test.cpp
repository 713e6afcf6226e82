#include "common/sync/agreed_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/seed.h"
#include "tests/world/test_scene.h"

namespace padr::sync {
namespace {

constexpr int kPeers = 3;
constexpr Tick kTicks = 400;
constexpr std::size_t kKept = 512;

/// A made-up log: avatars that jump about, claims that contend, holds that come and go.
std::vector<Bundle> random_log(std::uint64_t seed, int bodies) {
  Rng rng(seed);
  const auto coordinate = [&rng](double hi) { return static_cast<float>(rng.uniform(0.5, hi)); };
  std::vector<Bundle> log;
  for (PeerId p = 0; p < kPeers; ++p) {
    std::uint32_t index = 0;
    for (Tick t = 1 + p; t < kTicks; t += 3 + static_cast<Tick>(rng.below(25))) {
      Bundle b;
      b.peer = p;
      b.index = index++;
      b.tick = t;
      if (rng.chance(0.8)) {
        AvatarUpdate a;
        a.model = static_cast<Model>(rng.below(4));
        a.position = {coordinate(9.5), coordinate(7.5)};
        a.velocity = {coordinate(3), -coordinate(3)};
        a.control = {coordinate(9.5), coordinate(7.5)};
        b.avatar = a;
      }
      for (EntityId body = 0; body < bodies; ++body) {
        if (!rng.chance(0.12)) continue;
        BodyUpdate u;
        u.body = body;
        u.held = rng.chance(0.5);
        u.has_state = rng.chance(0.8);
        u.epoch = 1 + rng.below(4);
        u.claimed = t - static_cast<Tick>(rng.below(static_cast<std::uint32_t>(std::min(t, 3)) + 1));
        u.release = rng.chance(0.1);
        u.state.position = {coordinate(9.5), coordinate(7.5)};
        u.state.velocity = {coordinate(4), -coordinate(4)};
        b.bodies.push_back(u);
      }
      log.push_back(b);
    }
  }
  return log;
}

struct Heard {
  std::vector<std::uint64_t> hashes;
  std::vector<Tick> ticks;
  std::uint64_t most_replayed = 0;  ///< steps, in one tick
  int behind = 0;                   ///< ticks that left something to be replayed
};

/// Plays the log into one AgreedWorld, every bundle `delay` ticks late as drawn from `seed`, and returns what it
/// confirmed.
Heard play(const Scene& scene, const std::vector<Bundle>& log, bool replay, std::uint64_t seed, Tick longest_delay,
           std::size_t budget = 10'000) {
  Heard heard;
  AgreedWorld world(scene, {kPeers, kPeers, 0, true, replay, {}, kKept, budget},
                    [&heard](const FoldState& s, std::uint64_t hash) {
                      heard.hashes.push_back(hash);
                      heard.ticks.push_back(s.tick);
                    });
  Rng rng(seed);
  std::vector<std::pair<Tick, const Bundle*>> arrivals;
  for (const Bundle& b : log) {
    const Tick delay = b.peer == 0 ? 0 : static_cast<Tick>(rng.below(static_cast<std::uint32_t>(longest_delay) + 1));
    arrivals.emplace_back(b.tick + delay, &b);
  }
  std::vector<std::uint32_t> counts(kPeers, 0);
  for (Tick t = 1; t < kTicks + longest_delay + 2; ++t) {
    world.step();
    for (const auto& [at, b] : arrivals)
      if (at == t) world.insert(*b);
    for (PeerId p = 1; p < kPeers; ++p) {  // a mark of 8 ticks ago, as if it came over the link
      const Tick marked = t - 8;
      const auto count =
          std::count_if(log.begin(), log.end(), [&](const Bundle& b) { return b.peer == p && b.tick <= marked; });
      if (marked >= 0) world.mark(p, marked, static_cast<std::uint32_t>(count));
    }
    const std::uint64_t before = world.replayed_steps();
    world.catch_up();
    world.confirm();
    heard.most_replayed = std::max(heard.most_replayed, world.replayed_steps() - before);
    heard.behind += world.replaying() ? 1 : 0;
  }
  return heard;
}

// A replay that is too long for a tick is spread over many, and what comes late meanwhile over more.
TEST(AgreedWorld, ReplaysThatAreLeftForLaterComeOutTheSame) {
  const std::uint64_t seed = test::seed();
  for (std::uint64_t round = 0; round < 4; ++round) {
    const Scene scene = test::busy_scene(seed + round, 30);
    const auto log = random_log(derive_seed(seed, round), 30);
    const Heard punctual = play(scene, log, true, 1, 150);
    const Heard slow = play(scene, log, true, 1, 150, 0);
    const Heard slower = play(scene, log, true, 1, 150, 40);
    EXPECT_GT(slow.behind, 30) << "then nothing was tested";
    EXPECT_LE(slow.most_replayed, 4U);
    EXPECT_GT(punctual.most_replayed, 40U);
    for (const Heard* h : {&slow, &slower}) {
      ASSERT_GT(h->hashes.size(), 350U);
      for (std::size_t i = 0; i < std::min(h->hashes.size(), punctual.hashes.size()); ++i)
        ASSERT_EQ(h->hashes[i], punctual.hashes[i]) << "tick " << i << ", seed " << seed + round;
    }
  }
}

TEST(AgreedWorld, ConfirmedIsTheSameWhateverTheOrderOfArrival) {
  const std::uint64_t seed = test::seed();
  for (std::uint64_t round = 0; round < 6; ++round) {
    const Scene scene = test::busy_scene(seed + round, 30);
    const auto log = random_log(derive_seed(seed, round), 30);
    const Heard punctual = play(scene, log, true, 1, 0);
    const Heard late = play(scene, log, true, 2, 40);
    const Heard very_late = play(scene, log, true, 3, 150);
    const Heard follower = play(scene, log, false, 4, 90);  // only ever stepped forward
    const std::size_t n =
        std::min({punctual.hashes.size(), late.hashes.size(), follower.hashes.size(), very_late.hashes.size()});
    ASSERT_GT(n, 350U);
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_EQ(punctual.ticks[i], static_cast<Tick>(i));
      ASSERT_EQ(late.hashes[i], punctual.hashes[i]) << "tick " << i;
      ASSERT_EQ(very_late.hashes[i], punctual.hashes[i]) << "tick " << i;
      ASSERT_EQ(follower.hashes[i], punctual.hashes[i]) << "tick " << i;
    }
  }
}

// Longer than states are kept for: confirmed is then folded anew, with the same result, and some of it in every tick.
TEST(AgreedWorld, AStallBeyondWhatIsKeptChangesNothing) {
  const Scene scene = test::busy_scene(5, 20);
  constexpr Tick kEnd = 1900;
  std::vector<std::vector<std::uint64_t>> hashes(3);
  std::vector<std::uint64_t> predicted;
  for (std::size_t variant = 0; variant < 3; ++variant) {
    AgreedWorld world(scene, {2, 2, 0, true, true, {}, kKept, variant == 2 ? std::size_t{100} : 10'000},
                      [&](const FoldState&, std::uint64_t hash) { hashes[variant].push_back(hash); });
    Bundle late;
    late.peer = 1;
    late.tick = 20;
    late.avatar = AvatarUpdate{};
    late.avatar->position = {5, 4};
    late.avatar->velocity = {1, 0};
    for (Tick t = 1; t <= kEnd; ++t) {
      world.step();
      const bool stalled = variant > 0 && t < 1400;
      if (!stalled) {
        if (t >= 20) world.insert(late);
        world.mark(1, t, t >= 20 ? 1 : 0);
      }
      const std::size_t before = hashes[variant].size();
      world.catch_up();
      world.confirm();
      if (variant == 2) {
        EXPECT_LE(hashes[variant].size() - before, 600U) << "what is kept, and a few";
      }
    }
    EXPECT_FALSE(world.replaying());
    predicted.push_back(hash_of(world.predicted_state()));
  }
  for (const std::size_t late : {1U, 2U}) {
    ASSERT_EQ(hashes[0].size(), hashes[late].size());
    EXPECT_EQ(hashes[0], hashes[late]);
    EXPECT_EQ(predicted[0], predicted[late]);
  }
}

/// A world of peers of whom this is slot 0.
AgreedWorld small_world(const Scene& scene, int peers, bool replay) {
  AgreedConfig c;
  c.slots = c.peers = peers;
  c.replay = replay;
  return {scene, c, {}};
}

// Once, without replay, a claim that came more than 2 s late was refused, and so was all that its owner said of the
// body from then on.
TEST(AgreedWorld, AClaimThatComesLateIsTakenWithAndWithoutReplay) {
  const Scene scene = test::busy_scene(2, 3);
  for (const bool replay : {true, false})
    for (const Tick late : {60, 125, 300}) {
      AgreedWorld w = small_world(scene, 2, replay);
      while (w.now() < 100 + late) w.step();
      BodyUpdate u;
      u.body = 0;
      u.has_state = true;
      u.epoch = 1;
      u.claimed = 100;
      u.state.position = {5, 4};
      Bundle b;
      b.peer = 1;
      b.tick = 100;
      b.bodies = {u};
      w.insert(b);
      w.catch_up();
      w.step();
      EXPECT_EQ(w.predicted_state().authority[0].holder(), 1) << replay << ", late by " << late;
    }
}

// Once, without replay, it took the avatar of whoever had the slot by then out of the predicted world.
TEST(AgreedWorld, WhatAFormerOccupantSaidLastIsNotTheNextOnes) {
  const Scene scene = test::busy_scene(2, 3);
  for (const bool replay : {true, false}) {
    AgreedWorld w = small_world(scene, 3, replay);
    while (w.now() < 100) w.step();
    Bundle leave;
    leave.peer = 2;
    leave.tick = 90;
    leave.leave = true;
    Bundle by;
    by.peer = 1;
    by.tick = 99;
    by.admission = sync::Admission{};
    by.admission->slot = 2;
    by.admission->incarnation = 5;
    by.admission->first = 1;
    by.admission->have = {0, 0, 1};
    w.insert(by);
    w.close(2, 1);
    w.open(2, 99);
    for (int i = 0; i < 5; ++i) w.step();
    w.insert(leave);
    for (int i = 0; i < 5; ++i) w.step();
    EXPECT_TRUE(w.predicted_state().members[2].present) << replay;
    EXPECT_TRUE(w.predicted_state().avatars[2].present) << replay;
  }
}

TEST(AgreedWorld, ReplayCanBeTurnedOffInTheMiddleOfOne) {
  const Scene scene = test::busy_scene(9, 25);
  std::vector<std::vector<std::uint64_t>> hashes(2);
  for (std::size_t variant = 0; variant < 2; ++variant) {
    AgreedWorld world(scene, {2, 2, 0, true, true, {}, kKept, variant == 1 ? std::size_t{0} : 10'000},
                      [&](const FoldState&, std::uint64_t hash) { hashes[variant].push_back(hash); });
    Bundle b;
    b.peer = 1;
    b.tick = 30;
    b.avatar = AvatarUpdate{Cause::kThreshold, {3, 3}, {2, 1}, true, Model::kInput, {8, 6}};
    for (Tick t = 1; t <= 300; ++t) {
      world.step();
      if (t == 200) world.insert(b);
      if (t >= 200) world.mark(1, t, 1);
      world.catch_up();
      if (t == 205) {
        EXPECT_EQ(world.replaying(), variant == 1);
        world.set_replay(false);
        EXPECT_FALSE(world.replaying());
      }
      if (t == 220) world.set_replay(true);
      world.confirm();
    }
  }
  EXPECT_EQ(hashes[0].size(), 301U);
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(AgreedWorld, ALateUpdateMakesPredictedWhatItWouldHaveBeen) {
  const Scene scene = test::busy_scene(8, 25);
  AgreedWorld punctual(scene, {2, 2, 0, true, true, {}}, {});
  AgreedWorld late(scene, {2, 2, 0, true, true, {}}, {});
  Bundle b;
  b.peer = 1;
  b.tick = 30;
  b.avatar = AvatarUpdate{Cause::kThreshold, {3, 3}, {2, 1}, true, Model::kInput, {8, 6}};
  for (Tick t = 1; t <= 60; ++t) {
    for (AgreedWorld* w : {&punctual, &late}) {
      w->step();
      if (t == (w == &punctual ? 30 : 55)) w->insert(b);
      w->catch_up();
    }
    const bool same = hash_of(punctual.predicted_state()) == hash_of(late.predicted_state());
    EXPECT_EQ(same, t < 30 || t >= 55) << "tick " << t;
  }
  EXPECT_EQ(late.replayed_steps(), 25U);
}

}  // namespace
}  // namespace padr::sync
