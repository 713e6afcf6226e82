// Who comes, leaves, falls silent or goes another way, as replicas see it.
#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "tests/replica/mesh.h"
#include "tests/seed.h"

namespace padr::node {
namespace {

// Once, updates that a leaving peer had not yet heard were forgotten as soon as it was known to leave.
TEST(Replica, AllWhoLeaveAtOnceStillHearEverythingOfOneAnother) {
  const std::uint64_t base = test::seed(1);
  for (std::uint64_t seed = base; seed < base + 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    constexpr int kPeers = 4;
    Mesh mesh(kPeers, "delay 100ms 50ms loss 10%", seed);
    std::vector<bool> running(kPeers, true);
    std::vector<Tick> ended(kPeers, -1);
    for (Tick t = 0; t < 240; ++t) mesh.step(running);
    for (PeerId p = 0; p < kPeers; ++p) mesh[p].leave();
    const Tick left = mesh.now() + 1;
    for (Tick t = 0; t < 1200 && running != std::vector<bool>(kPeers, false); ++t) {
      mesh.step(running);
      for (PeerId p = 0; p < kPeers; ++p) {
        if (!running[p] || !mesh[p].delivered()) continue;
        running[p] = false;
        ended[p] = mesh.now();
      }
    }
    for (PeerId p = 0; p < kPeers; ++p) {
      EXPECT_GE(ended[p], left) << "peer " << int{p} << " never got through";
      EXPECT_GT(mesh[p].agreed().confirmed().tick, left) << "peer " << int{p};
      for (PeerId q = 0; q < kPeers; ++q)
        EXPECT_EQ(mesh[p].seat(q).presence == Presence::kLeft, q != p) << int{p} << " of " << int{q};
    }
  }
}

TEST(Replica, ALeaversAvatarGoesAndItsBodiesAreFree) {
  Mesh mesh(2, "", 1);
  std::vector<bool> running(2, true);
  for (Tick t = 0; t < 300; ++t) mesh.step(running);
  mesh[1].leave();
  for (Tick t = 0; t < 30; ++t) mesh.step(running);
  const sync::FoldState& s = mesh[0].agreed().confirmed();
  EXPECT_FALSE(s.avatars[1].present);
  for (const sync::Authority& a : s.authority) EXPECT_NE(a.holder(), 1);
  EXPECT_EQ(mesh[0].seat(1).presence, Presence::kLeft);
}

TEST(Replica, SurvivesGarbageAndItsOwnAndForeignDatagrams) {
  Mesh mesh(2, "", 1);
  std::vector<bool> running(2, true);
  Rng rng(test::seed());
  std::vector<wire::Bytes> heard;
  for (Tick t = 0; t < 120; ++t) {
    mesh.step(running);
    for (const Outgoing& o : mesh[1].outgoing()) heard.push_back(o.bytes);
  }
  const std::uint64_t hash = mesh[0].live_hash();
  for (int i = 0; i < 20000; ++i) {
    wire::Bytes bytes = heard[rng.below(static_cast<std::uint32_t>(heard.size()))];
    if (i % 3 == 0) bytes.resize(rng.below(static_cast<std::uint32_t>(bytes.size())));
    if (i % 3 == 1) bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] ^= std::byte{1};
    mesh[0].receive(bytes, tick_start(mesh.now()));  // every third whole: heard before
  }
  EXPECT_EQ(mesh[0].live_hash(), hash);
  const ReplicaStats& stats = mesh[0].stats();
  EXPECT_GT(stats.dropped[static_cast<std::size_t>(sync::DropReason::kDuplicate)], 5000U);
  EXPECT_GT(stats.dropped[static_cast<std::size_t>(sync::DropReason::kSeal)], 10000U);
  for (Tick t = 0; t < 120; ++t) mesh.step(running);
  EXPECT_GT(mesh[0].agreed().confirmed().tick, 200);
  EXPECT_EQ(stats.hash_mismatches, 0U);
}

// An order that nobody takes ends its peer's log, and then those that came after it were none. Once, whoever was
// admitted by one of them sat in its slot all the same.
TEST(Replica, AnOrderCountsOnceAllUpdatesBeforeItAreHere) {
  ReplicaConfig c;
  c.self = 1;
  c.peers = 2;
  c.slots = 3;
  const auto told = [](std::uint32_t index) {
    sync::Bundle b;
    b.peer = 0;
    b.index = index;
    b.tick = static_cast<Tick>(10 + index);
    return b;
  };
  sync::Bundle admission = told(1);
  admission.admission.emplace();
  admission.admission->slot = 2;
  admission.admission->incarnation = 5;
  admission.admission->at = ipv4({10, 0, 0, 3}, 7000);
  admission.admission->have = {1, 0, 0};
  sync::Bundle removal = told(2);
  removal.removals.push_back({2, 5, 0});
  for (const bool void_at_last : {false, true}) {
    Replica replica(scenarios::load_embedded("arena", 1), c);
    for (int i = 0; i < 60; ++i) replica.step({});
    EXPECT_EQ(replica.relay(0, 0, {admission}, kNoPeer), sync::DropReason::kNone);
    EXPECT_FALSE(replica.seat(2).there()) << "update 0 is missing";
    if (void_at_last) {
      sync::Bundle order;
      order.removals.push_back({0, 0, 0});
      replica.order(order);
      replica.step({});
      EXPECT_FALSE(replica.seat(0).there());
      EXPECT_FALSE(replica.seat(2).there());
      continue;
    }
    EXPECT_EQ(replica.relay(0, 0, {told(0)}, kNoPeer), sync::DropReason::kNone);
    EXPECT_TRUE(replica.seat(2).there());
    EXPECT_EQ(replica.relay(0, 0, {removal}, kNoPeer), sync::DropReason::kNone);
    EXPECT_FALSE(replica.seat(2).there());
  }
}

// Once, the world kept the first occupant and the roster the second one. Whoever is removed was never removed from the
// world then, and all who came later waited for it.
sync::Bundle admission_to_slot_1(std::uint32_t incarnation, std::vector<std::uint32_t> have) {
  sync::Bundle order;
  order.admission.emplace();
  order.admission->slot = 1;
  order.admission->incarnation = incarnation;
  order.admission->at = ipv4({10, 0, 0, 3}, 7000);
  order.admission->have = std::move(have);
  return order;
}

TEST(Replica, AnAdmissionToATakenSlotCountsInTheWorldAsInTheRoster) {
  ReplicaConfig c;
  c.peers = 1;
  c.slots = 3;
  Replica replica(scenarios::load_embedded("arena", 1), c);
  const auto give = [&replica](const sync::Bundle& order) {
    replica.order(order);
    for (int i = 0; i < 10; ++i) replica.step({});
  };
  for (const std::uint32_t incarnation : {5U, 9U, 7U}) {
    give(admission_to_slot_1(incarnation, {1, 0, 0}));
  }
  EXPECT_EQ(replica.seat(1).incarnation, 9U);
  sync::Bundle removal;
  removal.removals.push_back({1, 9, 0});
  give(removal);
  for (int i = 0; i < 120; ++i) replica.step({});
  const sync::FoldState& world = replica.agreed().confirmed();
  ASSERT_GT(world.tick, 60);
  EXPECT_EQ(world.members[1].incarnation, 9U);
  EXPECT_FALSE(world.members[1].present);
  EXPECT_FALSE(replica.seat(1).there());
}

// It has the seat now. Once, whoever had it before seemed to be there still, and was not looked for when it was
// elsewhere.
TEST(Replica, ANewcomersSeatIsNoLongerThatOfWhoHadItBefore) {
  const Scene scene = scenarios::load_embedded("arena", 1);
  ReplicaConfig c;
  c.peers = 1;
  c.slots = 2;
  Replica founder(scene, c);
  founder.order(admission_to_slot_1(1, {0, 0}));
  for (int i = 0; i < 60; ++i) founder.step({});
  sync::Transfer start = founder.transfer();
  ASSERT_TRUE(start.state.members[1].present);
  const Tick before = founder.now();
  sync::Bundle removal;
  removal.removals.push_back({1, 1, 0});
  founder.order(removal);
  founder.step({});
  founder.order(admission_to_slot_1(2, {0, 0}));
  founder.step({});
  for (const sync::Bundle& b : founder.agreed().log().since(before + 1)) start.tail.push_back(b);
  c.self = 1;
  c.incarnation = 2;
  const Replica newcomer(scene, c, start, founder.now());
  ASSERT_TRUE(newcomer.member());
  EXPECT_FALSE(newcomer.seat(1).there());
  EXPECT_FALSE(newcomer.seat(1).at.is_set());
}

// A newcomer to a session whose confirmed world lags far behind has many ticks to step up to.
TEST(Replica, ANewcomerCatchesUpInPartsToTheSameBits) {
  const Scene scene = scenarios::load_embedded("arena", 1);
  ReplicaConfig founder_config;
  founder_config.peers = 1;
  founder_config.slots = 2;
  Replica founder(scene, founder_config);
  for (int i = 0; i < 200; ++i) founder.step(scene.bodies.front().position);
  ReplicaConfig config;
  config.self = 1;
  config.slots = 2;
  config.incarnation = 1;
  constexpr Tick kPart = 60;
  constexpr Tick kBehind = 10 * kPart;
  const sync::Transfer start = founder.transfer();
  const Tick then = start.state.tick;
  Replica parts(scene, config, start, then + kBehind);
  EXPECT_EQ(parts.now(), then);
  for (Tick t = kPart; t < kBehind; t += kPart) {
    EXPECT_FALSE(parts.catch_up(kPart));
    EXPECT_EQ(parts.now(), then + t);
  }
  EXPECT_TRUE(parts.catch_up(kPart));
  EXPECT_EQ(parts.now(), then + kBehind);
  Replica at_once(scene, config, start, then + kBehind);
  EXPECT_TRUE(at_once.catch_up(kBehind));
  EXPECT_EQ(parts.live_hash(), at_once.live_hash());
  EXPECT_EQ(state_hash(parts.agreed().predicted_state()), state_hash(at_once.agreed().predicted_state()));
}

/// Of peer 1 as peer 0 sees it, which refuses an update of peer 1's and 3 s later does not listen for 4 s.
template <typename Deafen, typename Listen>
Tick arrears_after(Mesh& mesh, bool refuses, const Deafen& deafen, const Listen& listen) {
  const Replica& n = mesh[0];
  const View view{n.roster(), n.agreed().log(), n.live().world().scene()};
  std::vector<bool> running(2, true);
  const auto run = [&](Tick ticks) {
    for (Tick t = 0; t < ticks; ++t) mesh.step(running);
  };
  mesh.settle();
  run(240);
  mesh[0].set_judge([since = mesh.now(), refuses](const sync::StatePacket& p, PeerId) {
    const bool refused = refuses && !p.updates.empty() && p.updates.back().tick >= since;
    return refused ? sync::DropReason::kRight : sync::DropReason::kNone;
  });
  mesh[1].order({});
  run(180);
  EXPECT_EQ(view.arrears(1) > 170, refuses);
  deafen(running);
  run(240);
  listen(running);
  run(30);
  return view.arrears(1);
}

// Once, all that it owed was forgiven: another 8 s passed until it was cut off, and the others joined anew before.
TEST(Replica, WhoCouldTellNothingForAWhileIsForgivenThatTimeOnly) {
  for (const bool refuses : {false, true}) {
    const auto expect_forgiven = [refuses](Tick arrears) {
      EXPECT_GE(arrears, refuses ? 170 : 0);
      EXPECT_LE(arrears, refuses ? 240 : 60);
    };
    Mesh frozen(2, "delay 30ms", 1);
    expect_forgiven(arrears_after(
        frozen, refuses, [&](std::vector<bool>&) { frozen[0].freeze(1, true); },
        [&](std::vector<bool>&) { frozen[0].freeze(1, false); }));
    Mesh held_up(2, "delay 30ms", 1);
    expect_forgiven(arrears_after(
        held_up, refuses, [](std::vector<bool>& running) { running[1] = false; },
        [](std::vector<bool>& running) { running[1] = true; }));
  }
}

// Once, who had come into reach again was cut off for what it could not have acknowledged meanwhile.
TEST(Replica, WhoCouldAcknowledgeNothingForAWhileIsForgivenThatTimeOnly) {
  Mesh mesh(2, "delay 30ms", 1);
  std::vector<bool> running(2, true);
  const auto run = [&](Tick ticks) {
    for (Tick t = 0; t < ticks; ++t) mesh.step(running);
  };
  mesh.settle();
  run(240);
  mesh[1].set_judge([since = mesh.now()](const sync::StatePacket& p, PeerId) {
    const bool refused = !p.updates.empty() && p.updates.back().tick >= since;
    return refused ? sync::DropReason::kRight : sync::DropReason::kNone;
  });
  mesh[0].order({});
  run(180);
  EXPECT_NEAR(mesh[0].roster().unacknowledged(1), 180, 10);
  running[1] = false;
  run(240);
  running[1] = true;
  run(30);
  EXPECT_NEAR(mesh[0].roster().unacknowledged(1), 180 + 30, 20);
}

// Nothing that the two say is acknowledged, so both soon send a mark a second only. Once, a pause of more than a second
// hid that a frozen peer answers, and whoever had frozen it by a liar's word never took it up again.
TEST(Replica, AFrozenPeerIsKnownToAnswerOnABadLink) {
  const std::uint64_t base = test::seed(1);
  for (std::uint64_t seed = base; seed < base + 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Mesh mesh(2, "delay 150ms 50ms loss 10%", seed);
    for (Tick t = 0; t < 40; ++t) mesh.step(std::vector<bool>(2, true));
    mesh[0].freeze(1, true);
    Tick known = 0;
    for (Tick t = 0; t < 900; ++t) {
      mesh.step(std::vector<bool>(2, true));
      const Seat& s = mesh[0].roster().seats[1];
      if (s.answered_frozen - s.answers_since >= kTicksPerSecond) ++known;
    }
    EXPECT_GT(known, 450);
  }
}

// Peer 0 is stuck at a tick after its fault, and peer 1 was until it went on to later ones. Once, only peer 1 learned
// of the difference: peer 0 had no hash of its own for what it was told, and cut peer 1 off instead of joining anew.
TEST(Replica, BothLearnOfADifferenceThoughOneIsStuck) {
  Mesh mesh(3, "delay 30ms", 1, {}, "arena", {60, 5, {0.25F, 0}});
  const auto run_to = [&](Tick until) {
    while (mesh.now() < until) mesh.step(std::vector<bool>(3, true));
  };
  run_to(40);
  mesh[1].freeze(2, true);
  run_to(150);
  mesh[0].freeze(2, true);
  run_to(200);
  ASSERT_LT(mesh[1].agreed().confirmed().tick, 60);
  const Tick stuck = mesh[0].agreed().confirmed().tick;
  ASSERT_GT(stuck, 90);
  mesh[1].freeze(2, false);
  run_to(450);
  ASSERT_EQ(mesh[0].agreed().confirmed().tick, stuck);
  EXPECT_GT(mesh[1].agreed().confirmed().tick, 300);
  EXPECT_TRUE(mesh[1].seat(0).differs);
  EXPECT_TRUE(mesh[0].seat(1).differs);
}

}  // namespace
}  // namespace padr::node
