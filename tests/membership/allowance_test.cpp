#include "common/participant/allowance.h"

#include <gtest/gtest.h>

namespace padr::test {
namespace {

using node::Allowance;

TEST(Allowance, SoManyASecondAndSoManyAtOnce) {
  Allowance a(1000, 5000, 5000, 0);
  EXPECT_FALSE(a.take(5001, 0));
  EXPECT_TRUE(a.take(5000, 0));
  EXPECT_FALSE(a.take(1, 0));
  EXPECT_FALSE(a.take(1000, kMicrosPerSecond - 1));
  EXPECT_TRUE(a.take(1000, kMicrosPerSecond));
  EXPECT_FALSE(a.take(5001, 100 * kMicrosPerSecond)) << "never more than at once";
  EXPECT_TRUE(a.take(5000, 100 * kMicrosPerSecond));
}

TEST(Allowance, WhatIsAddedCountsUpToWhatMayGoAtOnce) {
  Allowance a(0, 5000, 0, 0);
  EXPECT_FALSE(a.take(1, kMicrosPerSecond));
  a.add(300);
  EXPECT_TRUE(a.take(300, kMicrosPerSecond));
  EXPECT_FALSE(a.take(1, kMicrosPerSecond));
  a.add(9000);
  EXPECT_TRUE(a.take(5000, kMicrosPerSecond));
  EXPECT_FALSE(a.take(1, kMicrosPerSecond));
}

}  // namespace
}  // namespace padr::test
