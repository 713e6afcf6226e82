#include "common/link/loss.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "shell/netem_text.h"
#include "tests/link/harness.h"

namespace padr::link {
namespace {

using testing::expect_share;
using testing::seed;

struct LossCount {
  double lost = 0;
  double bursts = 0;  ///< runs of losses
  double isolated = 0;
  double mean_burst() const { return lost / bursts; }
};

LossCount count(std::string_view spec, int packets) {
  LossProcess process(seed(), shell::parse_netem(spec).loss);
  LossCount c;
  int run = 0;
  for (int i = 0; i < packets; ++i) {
    const bool lost = process.next();
    if (lost && run == 0) ++c.bursts;
    if (!lost && run == 1) ++c.isolated;
    run = lost ? run + 1 : 0;
    c.lost += lost ? 1 : 0;
  }
  return c;
}

TEST(Loss, NeverAndAlwaysAreExact) {
  for (const char* never : {"", "loss 0%", "loss gemodel 0%", "loss state 0%", "loss gemodel 50% 50% 0% 0%"}) {
    EXPECT_EQ(count(never, 100'000).lost, 0) << never;
  }
  for (const char* always : {"loss 100%", "loss 100% 50%", "loss gemodel 100% 100% 100% 100%"}) {
    EXPECT_EQ(count(always, 100'000).lost, 100'000) << always;
  }
}

TEST(Loss, HappensIsExactAtBothEnds) {
  EXPECT_FALSE(happens(0, 0));
  EXPECT_TRUE(happens(1, 0));
  EXPECT_FALSE(happens(1, 1));
  EXPECT_TRUE(happens(kAlways, 0xFFFFFFFFU));
  EXPECT_FALSE(happens(kAlways - 1, 0xFFFFFFFFU));
}

TEST(Loss, RandomLosesItsShareIndependently) {
  constexpr int kPackets = 1'000'000;
  const LossCount c = count("loss 5%", kPackets);
  expect_share(c.lost, kPackets, 0.05);
  expect_share(c.bursts, kPackets, 0.05 * 0.95);  // a loss after a packet that was not lost
}

/// P(X < t) of the stationary X = (1 - rho) V + rho X', V uniform, by iterating the distribution function on a grid.
double stationary_share(double rho, double t) {
  constexpr int kGrid = 20'000;
  std::vector<double> f(kGrid + 1);
  for (int i = 0; i <= kGrid; ++i) f[static_cast<std::size_t>(i)] = static_cast<double>(i) / kGrid;
  const auto at = [&](const std::vector<double>& values, double x) {
    const double position = std::clamp(x, 0.0, 1.0) * kGrid;
    const auto i = std::min(static_cast<std::size_t>(position), std::size_t{kGrid - 1});
    const double part = position - static_cast<double>(i);
    return values[i] * (1 - part) + values[i + 1] * part;
  };
  for (int round = 0; round < 40; ++round) {
    std::vector<double> integral(kGrid + 1);  // of f, from 0
    for (std::size_t i = 1; i <= kGrid; ++i) integral[i] = integral[i - 1] + (f[i - 1] + f[i]) / 2 / kGrid;
    const auto upto = [&](double y) { return y <= 0 ? 0 : at(integral, y) + std::max(0.0, y - 1); };
    for (std::size_t i = 0; i <= kGrid; ++i) {
      const double x = static_cast<double>(i) / kGrid;
      f[i] = rho / (1 - rho) * (upto(x / rho) - upto((x - (1 - rho)) / rho));
    }
  }
  return at(f, t);
}

TEST(Loss, CorrelationShrinksTheTailsAsNetemsDoes) {
  struct Case {
    const char* spec;
    double chance, rho;
    double known;  ///< measured on the kernel's formula
    double tolerance;
  };
  constexpr int kPackets = 1'000'000;
  for (const Case& c :
       {Case{"loss 1% 25%", 0.01, 0.25, 0.0, 0.00001}, Case{"loss 5% 25%", 0.05, 0.25, 0.0019, 0.0001},
        Case{"loss 10% 25%", 0.10, 0.25, 0.0176, 0.0002}, Case{"loss 10% 50%", 0.10, 0.50, 0.0011, 0.0001},
        Case{"loss 30% 25%", 0.30, 0.25, 0.234, 0.001}}) {
    SCOPED_TRACE(c.spec);
    const double share = stationary_share(c.rho, c.chance);
    EXPECT_NEAR(share, c.known, c.tolerance);
    // The autocorrelations of the indicator are at most rho^k, so they inflate the variance by this much at most.
    expect_share(count(c.spec, kPackets).lost, kPackets, share, (1 + c.rho) / (1 - c.rho));
  }
}

TEST(Loss, CorrelatedNumbersFollowTheFormula) {
  // The formula in exact integers against its statement x = v (1 - rho) + x' rho, on the same stream of v.
  Rng rng(seed());
  double last = rng.next_u32();
  CorrelatedRandom random(seed(), kAlways / 4);
  for (int i = 0; i < 1000; ++i) {
    last = 0.75 * rng.next_u32() + 0.25 * last;
    ASSERT_NEAR(random.next(), last, 4.0);
  }
}

TEST(Loss, GilbertHasItsRateAndMeanBurst) {
  constexpr int kPackets = 1'000'000;
  const double p = 0.01;
  const double r = 0.3;
  const LossCount c = count("loss gemodel 1% 30%", kPackets);
  const double lambda = 1 - p - r;  // of the two-state chain
  expect_share(c.lost, kPackets, p / (p + r), (1 + lambda) / (1 - lambda));
  const double deviation = std::sqrt(1 - r) / r;  // of a geometric burst length
  EXPECT_NEAR(c.mean_burst(), 1 / r, 6 * deviation / std::sqrt(c.bursts));
}

TEST(Loss, GilbertElliottLosesInBothStates) {
  constexpr int kPackets = 1'000'000;
  const double bad = 0.02 / (0.02 + 0.1);
  const LossCount c = count("loss gemodel 2% 10% 70% 0.1%", kPackets);
  const double lambda = 1 - 0.02 - 0.1;
  expect_share(c.lost, kPackets, bad * 0.7 + (1 - bad) * 0.001, (1 + lambda) / (1 - lambda));
}

TEST(Loss, GilbertElliottTestsTheStateBeforeTheTransition) {
  // Good to bad at once, back at once; lost while bad: packets 2, 4, 6 ... and not the first.
  LossProcess process(seed(), shell::parse_netem("loss gemodel 100% 100%").loss);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(process.next(), i % 2 == 1) << "packet " << i + 1;
}

TEST(Loss, OneParameterModelsAreBernoulli) {
  constexpr int kPackets = 1'000'000;
  for (const char* spec : {"loss gemodel 5%", "loss state 5%"}) {
    SCOPED_TRACE(spec);
    const LossCount c = count(spec, kPackets);
    expect_share(c.lost, kPackets, 0.05);
    expect_share(c.bursts, kPackets, 0.05 * 0.95);
  }
}

/// Stationary distribution of the four states (1 send, 2 send in burst, 3 lose in burst, 4 lose) by power iteration.
std::array<double, 4> stationary_states(double p13, double p31, double p32, double p23, double p14) {
  std::array<double, 4> s{1, 0, 0, 0};
  for (int i = 0; i < 20'000; ++i) {
    s = {s[0] * (1 - p13 - p14) + s[2] * p31 + s[3], s[1] * (1 - p23) + s[2] * p32,
         s[0] * p13 + s[1] * p23 + s[2] * (1 - p31 - p32), s[0] * p14};
  }
  return s;
}

TEST(Loss, FourStatesHaveTheirShares) {
  constexpr int kPackets = 1'000'000;
  const auto s = stationary_states(0.01, 0.2, 0.1, 0.4, 0.005);
  const LossCount c = count("loss state 1% 20% 10% 40% 0.5%", kPackets);
  // The slowest part of the chain, the stay in burst states, has a memory of about 1 / 0.2 packets.
  expect_share(c.lost, kPackets, s[2] + s[3], 30);
  // State 3 is left with 30 %, state 4 at once; a state 4 run may not touch one of state 3.
  const double runs = s[2] * 0.3 + s[3];
  expect_share(c.bursts, kPackets, runs, 5);
}

TEST(Loss, FourthStateLosesOneAtATime) {
  const LossCount c = count("loss state 0% 100% 0% 100% 30%", 100'000);
  EXPECT_EQ(c.lost, c.bursts);
  expect_share(c.lost, 100'000, 0.3 / 1.3, 1);
}

}  // namespace
}  // namespace padr::link
