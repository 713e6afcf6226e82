#include "peer/lateness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/model/rng.h"
#include "tests/seed.h"

namespace padr::peer {
namespace {

TEST(Lateness, OfNothingAndOfOne) {
  Lateness l;
  EXPECT_EQ(l.count(), 0U);
  EXPECT_EQ(l.worst(), 0);
  EXPECT_EQ(l.quantile(0.5), 0);
  l.add(16'667);
  for (const double share : {0.0, 0.5, 1.0}) EXPECT_EQ(l.quantile(share), 16'667) << share;
}

TEST(Lateness, WhatIsEarlyIsInTimeAndWhatIsVeryLateIsKept) {
  Lateness l;
  l.add(-5);
  EXPECT_EQ(l.worst(), 0);
  l.add(Micros{1} << 40U);
  EXPECT_EQ(l.worst(), Micros{1} << 40U);
  EXPECT_EQ(l.quantile(0.5), 0);
}

// Never below the true one, and an eighth above it at most.
TEST(Lateness, QuantilesAreTheTrueOnesToAnEighth) {
  const std::uint64_t seed = test::seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  Lateness l;
  std::vector<Micros> all;
  for (int i = 0; i < 10'000; ++i) {
    all.push_back(static_cast<Micros>(rng.below(1U << rng.below(26))));
    l.add(all.back());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(l.count(), all.size());
  EXPECT_EQ(l.worst(), all.back());
  for (const std::size_t rank : {1U, 100U, 2'500U, 5'000U, 9'000U, 9'900U, 9'999U, 10'000U}) {
    const Micros exact = all[rank - 1];
    const Micros told = l.quantile(static_cast<double>(rank) / 10'000);
    EXPECT_GE(told, exact) << rank;
    EXPECT_LE(told, exact + exact / 8 + 1) << rank;
  }
}

}  // namespace
}  // namespace padr::peer
