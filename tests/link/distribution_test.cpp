#include "common/link/distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shell/netem_text.h"

namespace padr::link {
namespace {

struct Moments {
  double mean = 0, deviation = 0, lowest = 0, highest = 0;
};

Moments moments(Distribution d) {
  const DistributionTable& t = *distribution_table(d);
  Moments m;
  for (const int v : t) m.mean += v;
  m.mean /= static_cast<double>(t.size());
  for (const int v : t) m.deviation += (v - m.mean) * (v - m.mean);
  m.deviation = std::sqrt(m.deviation / static_cast<double>(t.size())) / kDistributionScale;
  m.mean /= kDistributionScale;
  m.lowest = static_cast<double>(*std::min_element(t.begin(), t.end())) / kDistributionScale;
  m.highest = static_cast<double>(*std::max_element(t.begin(), t.end())) / kDistributionScale;
  return m;
}

TEST(Distribution, TablesAscend) {
  for (const auto d : {Distribution::kNormal, Distribution::kPareto, Distribution::kParetoNormal}) {
    const auto& t = *distribution_table(d);
    EXPECT_TRUE(std::is_sorted(t.begin(), t.end())) << shell::to_string(d);
  }
  EXPECT_EQ(distribution_table(Distribution::kUniform), nullptr);
}

TEST(Distribution, NormalIsTheInverseOfTheErrorFunction) {
  const auto& t = *distribution_table(Distribution::kNormal);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double x = static_cast<double>(t[i]) / kDistributionScale;
    const double share = 0.5 * std::erfc(-x / std::sqrt(2.0));
    // Half a unit of the table either side, and a little for the rounding of the comparison.
    const double slack = std::exp(-x * x / 2) / std::sqrt(2 * 3.14159265358979) * 0.51 / kDistributionScale + 1e-9;
    ASSERT_NEAR(share, (static_cast<double>(i) + 0.5) / 4096, slack) << "entry " << i;
    ASSERT_EQ(t[i], -t[4095 - i]);
  }
  const Moments m = moments(Distribution::kNormal);
  EXPECT_EQ(m.mean, 0);
  EXPECT_NEAR(m.deviation, 1, 0.001);
  EXPECT_NEAR(m.highest, 3.67, 0.01);
}

TEST(Distribution, ParetoIsItsQuantiles) {
  const auto& t = *distribution_table(Distribution::kPareto);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double exact = (std::pow(1 - (static_cast<double>(i) + 0.5) / 4096, -1.0 / 3) - 1.5) * 4 / 3;
    ASSERT_NEAR(static_cast<double>(t[i]) / kDistributionScale, std::min(exact, 4.0), 0.51 / kDistributionScale + 1e-4)
        << "entry " << i;
  }
  const Moments m = moments(Distribution::kPareto);
  EXPECT_NEAR(m.mean, -0.034, 0.005);
  EXPECT_NEAR(m.deviation, 0.82, 0.01);
  EXPECT_NEAR(m.lowest, -2.0 / 3, 0.001);
  EXPECT_NEAR(m.highest, 4, 0.001);
}

TEST(Distribution, ParetoNormalMixesQuantileByQuantile) {
  const auto& n = *distribution_table(Distribution::kNormal);
  const auto& p = *distribution_table(Distribution::kPareto);
  const auto& mixed = *distribution_table(Distribution::kParetoNormal);
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    ASSERT_NEAR(mixed[i], 0.25 * n[i] + 0.75 * p[i], 1.01) << "entry " << i;
  }
  const Moments m = moments(Distribution::kParetoNormal);
  EXPECT_NEAR(m.deviation, 0.83, 0.01);
}

TEST(Distribution, UniformCoversEveryNanosecondOnce) {
  std::set<Nanos> seen;
  for (std::uint32_t r = 0; r < 20; ++r) seen.insert(distributed(100, 10, nullptr, r));
  EXPECT_EQ(seen.size(), 20U);
  EXPECT_EQ(*seen.begin(), 90);
  EXPECT_EQ(*seen.rbegin(), 109);
}

TEST(Distribution, NoJitterIsTheMean) {
  for (const auto d : {Distribution::kUniform, Distribution::kNormal}) {
    EXPECT_EQ(distributed(7, 0, distribution_table(d), 0xFFFFFFFFU), 7);
  }
}

TEST(Distribution, TableEntryTimesJitterRoundedToTheNearest) {
  const auto& t = *distribution_table(Distribution::kNormal);
  for (const Nanos jitter : {Nanos{1}, Nanos{1000}, Nanos{20'000'000}, kMaxJitter}) {
    for (const std::uint32_t i : {0U, 1U, 2047U, 2048U, 4095U}) {
      const double exact = static_cast<double>(jitter) * t[i] / kDistributionScale;
      EXPECT_NEAR(static_cast<double>(distributed(0, jitter, &t, i + 4096 * 77)), exact, 0.5001) << jitter << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace padr::link
