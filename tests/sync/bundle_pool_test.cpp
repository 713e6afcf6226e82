#include "common/sync/bundle_pool.h"

#include <gtest/gtest.h>

#include <deque>

#include "common/model/ring.h"
#include "common/model/rng.h"
#include "tests/seed.h"

namespace padr::sync {
namespace {

Bundle of_bodies(std::size_t bodies) {
  Bundle b;
  b.peer = 2;
  b.index = 7;
  b.avatar = AvatarUpdate{};
  for (std::size_t i = 0; i < bodies; ++i) b.bodies.emplace_back().body = static_cast<EntityId>(i);
  return b;
}

TEST(BundlePool, WhatComesOutIsTheSameWhateverWasThereBefore) {
  BundlePool pool;
  Bundle full = of_bodies(9);
  full.leave = true;
  full.admission = Admission{};
  full.removals.resize(2);
  full.passed_on.push_back(of_bodies(1));
  full.going = true;
  full.passages.resize(1);
  full.signature = Signature{};
  for (const Bundle& b : {full, of_bodies(5), of_bodies(0), full, Bundle{}}) {
    Bundle copy = pool.copy(b);
    EXPECT_EQ(copy, b);
    pool.give_back(std::move(copy));
  }
}

TEST(BundlePool, MemoryIsUsedAgain) {
  BundlePool pool;
  for (const std::size_t bodies : {std::size_t{3}, kMaxBodiesPerBundle}) {
    const Bundle b = of_bodies(bodies);
    Bundle first = pool.copy(b);
    const BodyUpdate* const at = first.bodies.data();
    pool.give_back(std::move(first));
    EXPECT_EQ(pool.copy(b).bodies.data(), at) << bodies;
  }
}

TEST(BundlePool, TakesBackWhatIsNotFromItWithoutTrustingIt) {
  BundlePool pool;
  for (int i = 0; i < 20; ++i) pool.give_back(of_bodies(2));
  EXPECT_GE(pool.copy(of_bodies(0)).bodies.capacity(), 4U);
}

TEST(Ring, IsAQueue) {
  Rng rng(test::seed());
  Ring<int> ring(3);
  std::deque<int> queue;
  for (int i = 0; i < 5000; ++i) {
    if (queue.empty() || rng.chance(i % 1000 < 500 ? 0.6 : 0.4)) {
      ring.push_back(i);
      queue.push_back(i);
    } else {
      ASSERT_EQ(ring.pop_front(), queue.front());
      queue.pop_front();
    }
    ASSERT_EQ(ring.size(), queue.size());
    ASSERT_EQ(ring.empty(), queue.empty());
    if (queue.empty()) continue;
    const std::size_t at = rng.below(static_cast<std::uint32_t>(queue.size()));
    ASSERT_EQ(ring[at], queue[at]);
    ASSERT_EQ(ring.front(), queue.front());
    ASSERT_EQ(ring.back(), queue.back());
  }
}

}  // namespace
}  // namespace padr::sync
