#include <gtest/gtest.h>

#include <algorithm>

#include "common/model/rng.h"
#include "common/sync/agreed_world.h"
#include "common/sync/state_hash.h"
#include "tests/seed.h"
#include "tests/world/test_scene.h"

namespace padr::sync {
namespace {

constexpr int kPeers = 4;
constexpr Tick kTicks = 300;

struct Late {
  Tick arrives = 0;
  Bundle bundle;
};

/// Avatars that are put right now and then and carry on, and bodies that are claimed near where they are: what peers
/// tell one another, and up to half a second late.
class Story {
 public:
  Story(std::uint64_t seed, const Scene& scene) : rng_(seed), fold_(scene, kPeers, kPeers, true) {
    for (Tick t = 1; t < kTicks; ++t) {
      for (PeerId p = 0; p < kPeers; ++p)
        if (rng_.chance(0.06)) tell(p, t);
      for (const Late& l : all_)
        if (l.bundle.tick == t) fold_.apply(l.bundle);
      fold_.step();
    }
    std::stable_sort(all_.begin(), all_.end(), [](const Late& a, const Late& b) { return a.arrives < b.arrives; });
  }
  const std::vector<Late>& all() const { return all_; }

 private:
  Vec2 somewhere() { return {static_cast<float>(rng_.uniform(0.5, 9.5)), static_cast<float>(rng_.uniform(0.5, 7.5))}; }
  Vec2 a_bit() { return {static_cast<float>(rng_.uniform(-0.3, 0.3)), static_cast<float>(rng_.uniform(-0.3, 0.3))}; }

  void tell(PeerId p, Tick t) {
    Bundle b;
    b.peer = p;
    b.index = count_[p]++;
    b.tick = t;
    const world::World& w = fold_.world();
    const EntityId avatar = w.avatar(p);
    b.avatar = AvatarUpdate{Cause::kThreshold, w.position(avatar) + a_bit(), w.velocity(avatar), true, Model::kInput,
                            somewhere()};
    for (EntityId e = 0; e < w.bodies(); ++e) {
      if (distance(w.position(e), w.position(avatar)) > 1.2F || !rng_.chance(0.5)) continue;
      BodyUpdate u;
      u.body = e;
      u.held = rng_.chance(0.7);
      u.has_state = rng_.chance(0.7);
      u.epoch = fold_.authority()[e].epoch + 1;
      u.claimed = t;
      u.state = w.state(e);
      u.state.position = u.state.position + a_bit();
      b.bodies.push_back(u);
    }
    all_.push_back({t + static_cast<Tick>(rng_.below(30)), b});
  }

  Rng rng_;
  Fold fold_;
  std::uint32_t count_[kPeers] = {};
  std::vector<Late> all_;
};

/// What a world is at tick `now` that has known this from the beginning.
std::uint64_t from_the_beginning(const Scene& scene, std::vector<Bundle> known, Tick now) {
  std::sort(known.begin(), known.end(),
            [](const Bundle& a, const Bundle& b) { return std::pair(a.tick, a.peer) < std::pair(b.tick, b.peer); });
  Fold fold(scene, kPeers, kPeers, true);
  auto next = known.begin();
  for (;; fold.step()) {
    for (; next != known.end() && next->tick == fold.tick(); ++next) fold.apply(*next);
    if (fold.tick() == now) break;
  }
  FoldState s;
  fold.save(s);
  return hash_of(s);
}

/// Bodies 7: much room, few meet; 40: a crowd, where most have to do with most.
class LocalReplay : public testing::TestWithParam<int> {};

TEST_P(LocalReplay, ComesOutAsIfAllHadBeenKnownFromTheBeginning) {
  const std::uint64_t seed = test::seed();
  for (std::uint64_t run = 0; run < 4; ++run) {
    const Scene scene = test::busy_scene(derive_seed(seed, run), GetParam());
    const Story story(derive_seed(seed, run, 1), scene);
    AgreedWorld world(scene, {kPeers, kPeers, 0, true, true, {}}, {});
    std::vector<Bundle> known;
    auto next = story.all().begin();
    std::uint64_t local = 0;
    for (Tick t = 1; t < kTicks; ++t) {
      world.step();
      bool late = false;
      for (; next != story.all().end() && next->arrives <= t; ++next) {
        late = late || next->bundle.tick < t;
        world.insert(next->bundle);
        known.push_back(next->bundle);
      }
      world.catch_up();
      if (!late || t % 3 != 0) continue;
      ASSERT_EQ(hash_of(world.predicted_state()), from_the_beginning(scene, known, t))
          << "tick " << t << ", seed " << seed << ", run " << run;
    }
    local += world.locally_replayed_steps();
    EXPECT_GT(local, 0U) << "then nothing was tested";
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, LocalReplay, testing::Values(7, 16, 40));

}  // namespace
}  // namespace padr::sync
