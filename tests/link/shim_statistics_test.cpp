#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "common/link/shim.h"
#include "shell/netem_text.h"
#include "tests/link/harness.h"

namespace padr::link {
namespace {

using testing::expect_share;
using testing::Out;
using testing::seed;
using testing::seed_note;

constexpr std::uint32_t kPackets = 100'000;

/// Delays in microseconds of datagrams sent so far apart that they cannot meet.
std::vector<double> delays(std::string_view spec) {
  constexpr Micros kApart = 10'000'000;
  Shim shim(shell::parse_netem(spec), seed());
  std::vector<double> result;
  for (const Out& out : testing::stream(shim, kPackets, kApart)) {
    result.push_back(static_cast<double>(out.at - static_cast<Micros>(out.number) * kApart));
  }
  EXPECT_EQ(result.size(), kPackets);
  return result;
}

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}
double deviation(const std::vector<double>& v) {
  const double m = mean(v);
  double sum = 0;
  for (const double x : v) sum += (x - m) * (x - m);
  return std::sqrt(sum / static_cast<double>(v.size()));
}
/// Correlation of each value with the one before.
double lag_one(const std::vector<double>& v) {
  const double m = mean(v);
  double sum = 0;
  for (std::size_t i = 1; i < v.size(); ++i) sum += (v[i] - m) * (v[i - 1] - m);
  return sum / (deviation(v) * deviation(v) * static_cast<double>(v.size()));
}

TEST(ShimStatistics, JitterIsUniformByDefault) {
  for (const char* spec : {"delay 100ms 20ms", "delay 100ms 20ms distribution uniform"}) {
    SCOPED_TRACE(spec);
    const auto d = delays(spec);
    EXPECT_GE(*std::min_element(d.begin(), d.end()), 80'000);
    EXPECT_LE(*std::max_element(d.begin(), d.end()), 120'000);
    const double sd = 40'000 / std::sqrt(12.0);
    EXPECT_NEAR(mean(d), 100'000, 6 * sd / std::sqrt(kPackets) + 1) << seed_note();
    for (int tenth = 0; tenth < 10; ++tenth) {
      const double low = 80'000 + 4'000 * tenth;
      expect_share(
          static_cast<double>(std::count_if(d.begin(), d.end(), [&](double x) { return x > low && x <= low + 4'000; })),
          kPackets, 0.1);
    }
  }
}

TEST(ShimStatistics, JitterNormal) {
  const auto d = delays("delay 100ms 20ms distribution normal");
  EXPECT_NEAR(mean(d), 100'000, 6 * 20'000 / std::sqrt(kPackets) + 1) << seed_note();
  EXPECT_NEAR(deviation(d), 20'000, 6 * 20'000 / std::sqrt(2.0 * kPackets) + 20) << seed_note();
  const auto within = [&](double sigmas) {
    return static_cast<double>(
        std::count_if(d.begin(), d.end(), [&](double x) { return std::abs(x - 100'000) < sigmas * 20'000; }));
  };
  // The table's quantiles are 1/4096 wide, which blurs a share by at most one of them.
  for (const double sigmas : {0.5, 1.0, 2.0, 3.0}) {
    EXPECT_NEAR(within(sigmas) / kPackets, std::erf(sigmas / std::sqrt(2.0)),
                6 * 0.5 / std::sqrt(kPackets) + 1.0 / 4096)
        << seed_note();
  }
}

TEST(ShimStatistics, JitterParetoIsSkewed) {
  const auto d = delays("delay 100ms 20ms distribution pareto");
  EXPECT_NEAR(*std::min_element(d.begin(), d.end()), 100'000 - 20'000 * 2.0 / 3, 5);
  EXPECT_NEAR(mean(d), 100'000 - 0.034 * 20'000, 6 * 0.82 * 20'000 / std::sqrt(kPackets) + 100) << seed_note();
  // Its median is 4/3 (2^(1/3) - 3/2) below the middle.
  expect_share(static_cast<double>(std::count_if(
                   d.begin(), d.end(), [](double x) { return x < 100'000 + 20'000 * 4 / 3 * (std::cbrt(2.0) - 1.5); })),
               kPackets, 0.5);
}

TEST(ShimStatistics, CorrelationOfDelaysHardlyActs) {
  // As in the kernel: the delay is chosen by the correlated number modulo the width of the jitter, and the remainder
  // of a number that large remembers nothing.
  for (const char* spec : {"delay 100ms 20ms 25%", "delay 100ms 20ms 50% distribution normal"}) {
    SCOPED_TRACE(spec);
    const auto d = delays(spec);
    EXPECT_LT(std::abs(lag_one(d)), 6 / std::sqrt(kPackets)) << seed_note();
    const double sd = std::string_view(spec).ends_with("normal") ? 20'000 : 40'000 / std::sqrt(12.0);
    EXPECT_NEAR(deviation(d), sd, sd * 0.02) << seed_note();
  }
}

TEST(ShimStatistics, LossThroughTheShim) {
  Shim shim(shell::parse_netem("loss gemodel 1% 30%"), seed());
  const auto out = testing::stream(shim, kPackets, 1'000);
  EXPECT_EQ(out.size() + shim.stats().lost, kPackets);
  const double lambda = 1 - 0.31;
  expect_share(static_cast<double>(shim.stats().lost), kPackets, 0.01 / 0.31, (1 + lambda) / (1 - lambda));
}

TEST(ShimStatistics, DuplicatesAreTwins) {
  Shim shim(shell::parse_netem("duplicate 10%"), seed());
  const auto out = testing::stream(shim, kPackets, 1'000);
  expect_share(static_cast<double>(out.size() - kPackets), kPackets, 0.1);
  for (std::size_t i = 1; i < out.size(); ++i) {
    ASSERT_LE(out[i].number - out[i - 1].number, 1U);
    ASSERT_FALSE(i >= 2 && out[i].number == out[i - 2].number) << "three of one";
  }
}

TEST(ShimStatistics, DuplicateAndLossTogether) {
  // Lost (half): one copy, as it was duplicated. Not lost: the packet, and a clone that is lost half the time.
  Shim shim(shell::parse_netem("duplicate 100% loss 50%"), seed());
  const auto out = testing::stream(shim, kPackets, 1'000);
  expect_share(static_cast<double>(out.size() - kPackets), kPackets, 0.25);
  expect_share(static_cast<double>(shim.stats().lost), kPackets, 0.25);
  expect_share(static_cast<double>(shim.stats().duplicated), kPackets, 0.5);
}

TEST(ShimStatistics, ClonesAreDelayedOnTheirOwn) {
  Shim shim(shell::parse_netem("duplicate 100% delay 100ms 20ms"), seed());
  const auto out = testing::stream(shim, 1'000, 1'000'000);
  int apart = 0;
  for (std::size_t i = 0; i + 1 < out.size(); i += 2) apart += out[i].at != out[i + 1].at ? 1 : 0;
  EXPECT_GT(apart, 990);  // the same microsecond of 40,000 by chance
}

TEST(ShimStatistics, CorruptionFlipsOneBitAnywhere) {
  constexpr std::size_t kSize = 10;
  Shim shim(shell::parse_netem("corrupt 25%"), seed());
  std::array<int, kSize * 8> flips{};
  int corrupted = 0;
  for (std::uint32_t i = 0; i < kPackets; ++i) {
    const auto sent = testing::numbered(i, kSize);
    shim.accept(i, sent);
    const auto got = shim.release(i);
    ASSERT_TRUE(got && got->size() == kSize);
    int bits = 0;
    for (std::size_t b = 0; b < kSize * 8; ++b) {
      const auto mask = std::byte{1} << (b % 8);
      if (((*got)[b / 8] & mask) == (sent[b / 8] & mask)) continue;
      ++bits;
      ++flips[b];
    }
    ASSERT_LE(bits, 1);
    corrupted += bits;
  }
  EXPECT_EQ(shim.stats().corrupted, static_cast<std::uint64_t>(corrupted));
  expect_share(corrupted, kPackets, 0.25);
  for (std::size_t b = 0; b < flips.size(); ++b) {
    SCOPED_TRACE(b);
    expect_share(flips[b], corrupted, 1.0 / static_cast<double>(flips.size()));
  }
}

TEST(ShimStatistics, EmptyPayloadCannotBeCorrupted) {
  Shim shim(shell::parse_netem("corrupt 100%"), seed());
  shim.accept(0, {});
  EXPECT_EQ(shim.release(0), std::vector<std::byte>());
  EXPECT_EQ(shim.stats().corrupted, 0U);
}

TEST(ShimStatistics, ReorderSendsItsShareAtOnce) {
  Shim shim(shell::parse_netem("delay 10ms reorder 25%"), seed());
  const auto out = testing::stream(shim, kPackets, 20'000);
  std::size_t at_once = 0;
  for (const Out& o : out) at_once += o.at == static_cast<Micros>(o.number) * 20'000 ? 1 : 0;
  EXPECT_EQ(at_once, shim.stats().reordered);
  expect_share(static_cast<double>(at_once), kPackets, 0.25);
}

TEST(ShimStatistics, GapSparesThePacketsBetween) {
  // After each packet sent at once 4 are delayed for certain, then each goes with 25 %: 1 in 4 + 1 / 0.25.
  Shim shim(shell::parse_netem("delay 10ms reorder 25% gap 5"), seed());
  const auto out = testing::stream(shim, kPackets, 20'000);
  std::int64_t last = -5;
  std::vector<double> distances;
  for (const Out& o : out) {
    if (o.at != static_cast<Micros>(o.number) * 20'000) continue;
    ASSERT_GE(o.number - last, 5) << seed_note();
    if (last >= 0) distances.push_back(static_cast<double>(o.number - last));
    last = o.number;
  }
  const double sd = std::sqrt(0.75) / 0.25;
  EXPECT_NEAR(mean(distances), 8, 6 * sd / std::sqrt(static_cast<double>(distances.size()))) << seed_note();
}

TEST(ShimStatistics, JitterOvertakes) {
  // Neighbours 1/60 s apart with uniform jitter of +-20 ms: the second of two overtakes with probability
  // (1 - s)^2 / 2, s = 16.667 / 40.
  Shim shim(shell::parse_netem("delay 100ms 20ms"), seed());
  const auto out = testing::stream(shim, kPackets, 16'667);
  std::vector<std::size_t> place(kPackets);
  for (std::size_t i = 0; i < out.size(); ++i) place[out[i].number] = i;
  double overtaken = 0;
  for (std::size_t n = 1; n < kPackets; ++n) overtaken += place[n] < place[n - 1] ? 1 : 0;
  const double s = 16'667.0 / 40'000;
  expect_share(overtaken, kPackets, (1 - s) * (1 - s) / 2, 2);
}

}  // namespace
}  // namespace padr::link
