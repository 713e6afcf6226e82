// Bodies that nobody owns: a player's own world, or the agreed one.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/lab/session.h"
#include "tests/seed.h"

namespace padr {
namespace {

using trace::InconsistencyMeter;
using trace::View;

Technique with_unowned(const char* name, Unowned unowned) {
  Technique t = technique_by_name(name);
  t.unowned = unowned;
  return t;
}

BodyState predicted_state(const node::Replica& n, EntityId b) {
  const world::Kinematics& k = n.agreed().predicted_state().world.entities[b];
  return {k.position, k.angle, k.velocity, k.spin, k.awake};
}

TEST(Unowned, ThePapersTechniquesPlayThemOutAlone) {
  for (const auto name : technique_names()) {
    const bool papers = name == "fixed" || name == "adaptive" || name == "avatar-only";
    EXPECT_EQ(technique_by_name(name).unowned, papers ? Unowned::kLive : Unowned::kAgreed) << name;
    EXPECT_EQ(plays_unowned_alone(technique_by_name(name)), papers) << name;
  }
}

/// Runs it, and holds at every tick every body that nobody owns against its state in the predicted world: how many
/// differ, over all ticks and peers.
int differing(test::Session& s) {
  int n = 0;
  s.simulation->run([&](Tick) {
    for (PeerId p = 0; p < s.simulation->peers(); ++p) {
      const node::Replica& replica = s.simulation->replica(p);
      for (EntityId b = 0; b < replica.live().world().bodies(); ++b)
        if (replica.agreed().predicted_state().authority[b].holder() == kNoPeer &&
            replica.live().world().state(b) != predicted_state(replica, b))
          ++n;
    }
  });
  return n;
}

TEST(Unowned, ConfirmedWorldsAreIdenticalEitherWay) {
  const std::uint64_t seed = test::seed(4);
  for (const char* name : {"fixed", "adaptive", "full"})
    for (const Unowned unowned : {Unowned::kLive, Unowned::kAgreed}) {
      test::Session s("arena", 3, with_unowned(name, unowned), "delay 80ms 40ms loss 10%", seed, 20, 5);
      const int n = differing(s);
      if (unowned == Unowned::kLive)
        EXPECT_GT(n, 0) << name;
      else
        EXPECT_EQ(n, 0) << name;
      EXPECT_GT(s.simulation->confirmed_ticks(), 1300U);
      EXPECT_EQ(s.simulation->confirmed_mismatches(), 0U) << name << (unowned == Unowned::kLive ? " live" : " agreed");
    }
}

/// Whether the two avatars or one's bodies have met: from then on the other one has a say.
bool touches_second(const node::Replica& n) {
  const EntityId second = n.live().world().avatar(1);
  return std::any_of(n.live().touching().begin(), n.live().touching().end(),
                     [second](const Contact& c) { return c.first == second || c.second == second; });
}

/// Mean distance of bodies in the first player's live world from where they are when that player is alone, until it
/// meets the second, m.
double astray(Unowned unowned, std::uint64_t seed) {
  test::Session alone("arena", 2, technique_by_name("avatar-only"), "", seed, 20, 0, true);
  test::Session s("arena", 2, with_unowned("fixed", unowned), "", seed, 20, 0, true);
  double sum = 0;
  Tick t = 0;
  while (t < 20 * kTicksPerSecond) {
    alone.simulation->step();
    s.simulation->step();
    if (touches_second(alone.simulation->replica(0)) || touches_second(s.simulation->replica(0))) break;
    const world::View& a = alone.simulation->replica(0).live().world();
    const world::View& b = s.simulation->replica(0).live().world();
    for (EntityId e = 0; e < a.bodies(); ++e) sum += static_cast<double>(distance(a.position(e), b.position(e)));
    ++t;
  }
  EXPECT_GT(t, 5 * kTicksPerSecond) << "seed " << seed;
  return sum / t;
}

// Nobody but the first player moves: whatever its own model disturbs in the world of the second, its own world stays as
// it would be without anybody else, but for what it tells to have come to rest.
TEST(Unowned, APlayersOwnWorldStaysItsOwn) {
  const std::uint64_t first = test::seed(1);
  double agreed = 0;
  for (std::uint64_t seed = first; seed < first + 5; ++seed) {
    EXPECT_LT(astray(Unowned::kLive, seed), 0.01) << "seed " << seed;
    agreed += astray(Unowned::kAgreed, seed) / 5;
  }
  EXPECT_GT(agreed, 0.01) << "or nothing was tested";
}

// What somebody else has owned and given up is taken over as it was told.
TEST(Unowned, WhatAnotherOneLeavesIsTakenOverOnce) {
  const std::uint64_t seed = test::seed(2);
  test::Session s("arena", 2, technique_by_name("fixed"), "delay 50ms", seed, 30, 0, true);
  std::vector<PeerId> owner(s.scene.bodies.size(), kNoPeer);
  int given_up = 0;
  s.simulation->run([&](Tick t) {
    const node::Replica& n = s.simulation->replica(1);
    for (EntityId b = 0; b < owner.size(); ++b) {
      const PeerId now = n.agreed().predicted_state().authority[b].holder();
      if (owner[b] == 0 && now == kNoPeer) {
        ++given_up;
        EXPECT_EQ(n.live().world().state(b), predicted_state(n, b)) << "tick " << t << ", body " << b;
      }
      owner[b] = now;
    }
  });
  EXPECT_GT(given_up, 3);
}

TEST(Unowned, CanBeTurnedWhilePlaying) {
  test::Session s("arena", 2, technique_by_name("fixed"), "delay 50ms", test::seed(3), 90);
  const auto differ = [&] {
    const node::Replica& n = s.simulation->replica(0);
    int found = 0;
    for (EntityId b = 0; b < n.live().world().bodies(); ++b)
      if (n.agreed().predicted_state().authority[b].holder() == kNoPeer &&
          n.live().world().state(b) != predicted_state(n, b))
        ++found;
    return found;
  };
  const auto run_until_they_differ = [&](int seconds) {
    for (Tick t = 0; t < seconds * kTicksPerSecond && differ() == 0; ++t) s.simulation->step();
    EXPECT_GT(differ(), 0);
  };
  run_until_they_differ(30);
  s.simulation->retune(0, with_unowned("fixed", Unowned::kAgreed));
  for (Tick t = 0; t < kTicksPerSecond; ++t) s.simulation->step();
  EXPECT_EQ(differ(), 0);
  s.simulation->retune(0, with_unowned("fixed", Unowned::kLive));
  run_until_they_differ(30);
}

View view(float body, bool alone) {
  return {{{body, 0}, {0, 1}, {0, 2}, {0, 3}}, {{body + 1, 0}, {0, 1}, {0, 2}, {0, 3}}, alone};
}

// One body, which nobody owns, and three peers: at 0, 2 and 5 m, shown a metre farther; agreed at 10 m.
TEST(Unowned, IsMeasuredAgainstTheOtherViewsByHand) {
  const auto measured = [](bool alone, PeerId owner) {
    InconsistencyMeter m(3, 1);
    m.truth(0, {{owner, 0, 1, 2}, {true, true, true, true}, {{10, 0}, {0, 1}, {0, 2}, {0, 3}}});
    m.view(0, 0, view(0, alone));
    m.view(1, 0, view(2, alone));
    m.view(2, 0, view(5, alone));
    return std::vector{m.series(0)[0], m.series(1)[0], m.series(2)[0]};
  };
  const auto alone = measured(true, kNoPeer);
  EXPECT_FLOAT_EQ(alone[0].bodies_m, 3.5F);
  EXPECT_FLOAT_EQ(alone[1].bodies_m, 2.5F);
  EXPECT_FLOAT_EQ(alone[2].bodies_m, 4);
  EXPECT_FLOAT_EQ(alone[0].shown_m, 2.5F) << "shown at 1 m, the others have it at 2 and 5";
  EXPECT_FLOAT_EQ(measured(false, kNoPeer)[1].bodies_m, 8) << "from the agreed world";
  EXPECT_FLOAT_EQ(measured(true, 2)[0].bodies_m, 5) << "its owner's word counts";
}

TEST(Unowned, AViewWithoutOthersIsMeasuredAgainstTheAgreedWorld) {
  InconsistencyMeter m(1, 1);
  m.truth(0, {{kNoPeer, 0}, {true, true}, {{10, 0}, {0, 1}}});
  m.view(0, 0, {{{0, 0}, {0, 1}}, {{0, 0}, {0, 1}}, true});
  EXPECT_FLOAT_EQ(m.series(0)[0].bodies_m, 10);
}

}  // namespace
}  // namespace padr
