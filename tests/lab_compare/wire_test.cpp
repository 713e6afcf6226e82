#include <gtest/gtest.h>

#include <cmath>

#include "common/model/rng.h"
#include "common/scenarios/scenarios.h"
#include "common/wire/seal.h"
#include "tests/seed.h"
#include "tools/lab/alternatives/alternative.h"
#include "tools/lab/alternatives/bits.h"
#include "tools/lab/alternatives/quantised.h"
#include "tools/lab/compare/contestant.h"

namespace padr::lab::alternatives {
namespace {

TEST(Bits, WhatWasWrittenIsRead) {
  BitWriter w;
  w.put(5, 3);
  w.put_signed(-17, 6);
  w.put_small(0);
  w.put_small(7);
  w.put_small(0xFFFFFFFFU);
  w.put_float(-1.5F);
  BitWriter all;
  all.flag(true);
  all.append(w);
  EXPECT_EQ(all.bits(), w.bits() + 1);
  BitReader r(all.bytes());
  EXPECT_TRUE(r.flag());
  EXPECT_EQ(r.get(3), 5U);
  EXPECT_EQ(r.get_signed(6), -17);
  EXPECT_EQ(r.get_small(), 0U);
  EXPECT_EQ(r.get_small(), 7U);
  EXPECT_EQ(r.get_small(), 0xFFFFFFFFU);
  EXPECT_EQ(r.get_float(), -1.5F);
  EXPECT_TRUE(r.ok());
  r.get(32);
  EXPECT_FALSE(r.ok());
}

TEST(Quantiser, KeepsStatesWithinItsSteps) {
  const Scene scene = scenarios::load_embedded("arena", 1);
  const Quantiser z(scene);
  Rng rng(test::seed(1));
  Quantised base;
  for (int i = 0; i < 2000; ++i) {
    BodyState s;
    s.position = {static_cast<float>(rng.uniform(0, 20)), static_cast<float>(rng.uniform(0, 15))};
    s.velocity = {static_cast<float>(rng.uniform(-30, 30)), static_cast<float>(rng.uniform(-0.1, 0.1))};
    s.angle = static_cast<float>(rng.uniform(-50, 50));
    s.spin = static_cast<float>(rng.uniform(-30, 30));
    const Quantised q = z.quantise(s);
    const BodyState back = z.state(q);
    EXPECT_LE(distance(back.position, s.position), 0.0005F);
    EXPECT_LE(distance(back.velocity, s.velocity), 0.006F);
    EXPECT_NEAR(std::remainder(back.angle - s.angle, 2 * 3.14159265F), 0, 0.001F);
    for (const Fields f : {Fields{true, true}, Fields{true, false}, Fields{false, true}}) {
      BitWriter w;
      z.write(w, q, base, f);
      BitReader r(w.bytes());
      const Quantised read = z.read(r, base, f);
      EXPECT_TRUE(r.ok());
      EXPECT_EQ(read.x, q.x);
      EXPECT_EQ(read.y, q.y);
      if (f.turns) {
        EXPECT_EQ(read.angle, q.angle);
      }
      if (f.moves) {
        EXPECT_EQ(read.vx, q.vx);
      }
      if (f.moves && f.turns) {
        EXPECT_EQ(read.spin, q.spin);
      }
    }
    base = q;
  }
}

/// Whatever comes under a right tag, a peer stays standing and sane.
TEST(Alternatives, SurviveNonsense) {
  const Scene scene = scenarios::load_embedded("arena", 1);
  Rng rng(test::seed(2));
  for (const compare::Contestant& c : compare::all_contestants()) {
    const auto* const spec = std::get_if<Spec>(&c.how);
    if (spec == nullptr || c.group == compare::Group::kFrontier) continue;
    SCOPED_TRACE(c.id);
    const auto peer = make_alternative(scene, {0, 3, 1, *spec});
    for (int tick = 0; tick < 600; ++tick) {
      std::vector<std::byte> payload(rng.below(200));
      for (std::byte& b : payload) b = static_cast<std::byte>(rng.below(256));
      // Half of them look timely.
      if (payload.size() > 4 && rng.chance(0.5)) payload[2] = payload[1] = std::byte{0};
      const auto sender = static_cast<PeerId>(rng.below(4));
      peer->receive(wire::seal({wire::Kind::kState, sender, 1}, payload));
      peer->step({10, 7});
      for (EntityId e = 0; e < peer->world().entities(); ++e) ASSERT_TRUE(is_finite(peer->world().position(e)));
    }
    EXPECT_GT(peer->stats().datagrams_dropped, 0U);
  }
}

}  // namespace
}  // namespace padr::lab::alternatives
