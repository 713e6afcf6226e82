#include <gtest/gtest.h>

#include <ostream>
#include <vector>

#include "common/world/avatar_control.h"
#include "common/world/world.h"
#include "tests/world/test_scene.h"

namespace padr::world {
namespace {

std::uint64_t hash_of(const World& w) {
  Snapshot s;
  w.save(s);
  WideHasher h;
  add_to_hash(h, s);
  return h.value();
}

Vec2 target_at(std::uint64_t seed, PeerId p, Tick t) {
  Rng rng(derive_seed(seed, p, static_cast<std::uint64_t>(t / 45)));
  return {static_cast<float>(rng.uniform(0.5, 9.5)), static_cast<float>(rng.uniform(0.5, 7.5))};
}

/// What a peer does to a world between steps: drive avatars, change holds, overwrite a state now and then.
void act(World& w, std::uint64_t seed, Tick t) {
  for (PeerId p = 0; p < 2; ++p) {
    drive_avatar(w, p, target_at(seed, p, t));
    if (t % 20 == 0)
      for (EntityId b = 0; b < w.bodies(); ++b) {
        Rng rng(derive_seed(seed, b + 1000U * p, static_cast<std::uint64_t>(t / 20)));
        w.set_hold(p, b, rng.chance(0.4));
      }
  }
  if (t % 37 == 5) {
    Rng rng(derive_seed(seed, 77, static_cast<std::uint64_t>(t)));
    const auto b = static_cast<EntityId>(rng.below(static_cast<std::uint32_t>(w.bodies())));
    BodyState s = w.state(b);
    s.position = {static_cast<float>(rng.uniform(1, 9)), static_cast<float>(rng.uniform(1, 7))};
    s.velocity = {static_cast<float>(rng.uniform(-3, 3)), static_cast<float>(rng.uniform(-3, 3))};
    s.awake = rng.chance(0.8);
    if (!s.awake) {
      s.velocity = {};
      s.spin = 0;
    }
    w.set_state(b, s);
  }
}

void copy_rules(const World& from, World& to) {
  for (PeerId p = 0; p < from.slots(); ++p) {
    to.set_present(to.avatar(p), from.present(from.avatar(p)));
    for (EntityId b = 0; b < from.bodies(); ++b) to.set_hold(p, b, from.hold(p, b));
  }
}

struct Case {
  const char* name;
  int bodies;
  bool warm;
  float gravity;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class Restore : public ::testing::TestWithParam<Case> {};

// The claim everything rests on: restored anywhere, at any moment, in the midst of piles, a world goes on as the
// original.
TEST_P(Restore, PlaysOutBitForBitInAFreshAndInAUsedWorld) {
  const Case c = GetParam();
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = test::busy_scene(seed, c.bodies, c.warm, c.gravity);
    World original(scene, 2);
    World used(scene, 2);  // has a history of its own
    for (PeerId p = 0; p < 2; ++p) {
      original.set_present(original.avatar(p), true);
      used.set_present(used.avatar(p), true);
    }
    for (Tick t = 0; t < 100; ++t) {
      act(used, seed + 500, t);
      used.step();
    }
    for (Tick t = 0; t < 500; ++t) {
      act(original, seed, t);
      original.step();
      if (t % 83 != 40) continue;
      Snapshot s;
      original.save(s);
      World fresh(scene, 2);
      for (World* copy : {&fresh, &used}) {
        copy_rules(original, *copy);
        copy->restore(s);
        ASSERT_EQ(hash_of(*copy), hash_of(original)) << "just restored, tick " << t;
      }
      World reference(scene, 2);
      copy_rules(original, reference);
      reference.restore(s);
      std::vector<std::uint64_t> expected;
      Snapshot resume;
      original.save(resume);
      for (Tick u = t + 1; u < t + 80; ++u) {
        for (World* w : {&original, &fresh, &used}) {
          act(*w, seed, u);
          w->step();
        }
        ASSERT_EQ(hash_of(fresh), hash_of(original)) << "fresh world, tick " << t << " + " << u - t;
        ASSERT_EQ(hash_of(used), hash_of(original)) << "used world, tick " << t << " + " << u - t;
      }
      t += 79;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Restore,
                         ::testing::Values(Case{"sparse", 20, false, 0}, Case{"pile", 60, false, 0},
                                           Case{"pile_warm", 60, true, 0}, Case{"stack_warm", 40, true, -9.8F}),
                         [](const auto& scene) { return scene.param.name; });

TEST(RestoreKeeping, LeavesKeptEntitiesAndTheirContactsAlone) {
  const Scene scene = test::busy_scene(3, 40);
  World a(scene, 0);
  World b(scene, 0);
  for (int t = 0; t < 60; ++t) a.step();
  for (int t = 0; t < 90; ++t) b.step();
  std::vector<bool> keep(40, false);
  keep[7] = keep[8] = true;
  const BodyState kept = b.state(7);
  Snapshot s;
  a.save(s);
  b.restore(s, keep);
  EXPECT_EQ(b.state(7), kept);
  EXPECT_EQ(b.state(9), a.state(9));
  // Taking over a world's own state changes nothing, so a peer whose view is right never disturbs it.
  World c(scene, 0);
  World d(scene, 0);
  for (int t = 0; t < 300; ++t) {
    c.step();
    d.step();
    d.save(s);
    d.restore(s, keep);
    ASSERT_EQ(hash_of(c), hash_of(d)) << "tick " << t;
  }
}

}  // namespace
}  // namespace padr::world
