#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "common/link/shim.h"
#include "common/model/hash.h"
#include "shell/netem_text.h"
#include "tests/link/harness.h"

namespace padr::link {
namespace {

using testing::Out;

constexpr const char* kSpecs[] = {
    "",
    "delay 20ms 15ms",
    "delay 20ms 30ms distribution normal loss 10% 10%",
    "delay 5ms 2ms distribution pareto reorder 20% 50% gap 3 duplicate 10% corrupt 30%",
    "loss gemodel 5% 20% 80% 1% duplicate 30% 20% delay 3ms limit 4",
    "loss state 5% 50% 10% 60% 2% rate 200kbit 10 48 5 delay 10ms 10ms",
    "slot 3ms 9ms packets 2 delay 4ms 3ms",
    "slot distribution paretonormal 8ms 6ms bytes 200 delay 4ms 3ms duplicate 20%",
    "slot distribution normal 1ms 6ms packets 1 rate 500kbit",
};

struct Arrival {
  Micros at;
  std::vector<std::byte> bytes;
};

std::vector<Arrival> arrivals(std::uint64_t seed) {
  Rng rng(derive_seed(seed, 99));
  std::vector<Arrival> result;
  Micros now = 0;
  for (std::uint32_t i = 0; i < 2'000; ++i) {
    now += rng.chance(0.3) ? 0 : rng.below(4'000);
    result.push_back({now, testing::numbered(i, 4 + rng.below(100))});
  }
  return result;
}

using Bytes = std::vector<std::byte>;
struct Outcome {
  std::vector<Bytes> out;
  ShimStats stats;
  friend bool operator==(const Outcome&, const Outcome&) = default;
};

/// Feeds `arrivals`; before each, `poll(from, to)` may collect whenever it likes.
Outcome run(const char* spec, std::uint64_t seed, const std::vector<Arrival>& arrivals,
            const std::function<void(Shim&, Micros, Micros, std::vector<Bytes>&)>& poll) {
  Shim shim(shell::parse_netem(spec), seed);
  Outcome o;
  Micros before = 0;
  for (const Arrival& a : arrivals) {
    poll(shim, before, a.at, o.out);
    shim.accept(a.at, a.bytes);
    before = a.at;
  }
  poll(shim, before, before + 10'000'000, o.out);
  while (auto bytes = shim.release(before + 100'000'000)) o.out.push_back(std::move(*bytes));
  EXPECT_EQ(shim.in_flight(), 0U);
  o.stats = shim.stats();
  return o;
}

void drain(Shim& shim, Micros now, std::vector<Bytes>& out) {
  while (auto bytes = shim.release(now)) out.push_back(std::move(*bytes));
}

TEST(ShimDeterminism, PollingDoesNotMatter) {
  const auto seed = testing::seed();
  const auto in = arrivals(seed);
  for (const char* spec : kSpecs) {
    SCOPED_TRACE(std::string(spec) + "; " + testing::seed_note());
    const Outcome never = run(spec, seed, in, [](Shim&, Micros, Micros, std::vector<Bytes>&) {});
    const Outcome when_due = run(spec, seed, in, [](Shim& shim, Micros, Micros to, std::vector<Bytes>& out) {
      for (auto due = shim.next_due(); due && *due <= to; due = shim.next_due()) drain(shim, *due, out);
    });
    const Outcome often = run(spec, seed, in, [](Shim& shim, Micros from, Micros to, std::vector<Bytes>& out) {
      for (Micros t = from; t < to; t += 37) drain(shim, t, out);
    });
    Rng rng(seed);
    const Outcome now_and_then = run(spec, seed, in, [&](Shim& shim, Micros from, Micros, std::vector<Bytes>& out) {
      if (rng.chance(0.05)) drain(shim, from, out);
    });
    EXPECT_TRUE(never == when_due);
    EXPECT_TRUE(never == often);
    EXPECT_TRUE(never == now_and_then);
  }
}

TEST(ShimDeterminism, SameSeedSameOutcomeOtherSeedOther) {
  const auto in = arrivals(testing::seed());
  const auto nothing = [](Shim&, Micros, Micros, std::vector<Bytes>&) {};
  for (const char* spec : kSpecs) {
    SCOPED_TRACE(spec);
    const Outcome a = run(spec, 5, in, nothing);
    EXPECT_TRUE(a == run(spec, 5, in, nothing));
    if (*spec != '\0' && std::string_view(spec).find("slot distribution normal") == std::string_view::npos) {
      EXPECT_FALSE(a == run(spec, 6, in, nothing));
    }
  }
}

TEST(ShimDeterminism, SeedInTheSpecificationWins) {
  const auto in = arrivals(testing::seed());
  const auto nothing = [](Shim&, Micros, Micros, std::vector<Bytes>&) {};
  const Outcome a = run("delay 20ms 15ms loss 10% seed 42", 1, in, nothing);
  EXPECT_TRUE(a == run("delay 20ms 15ms loss 10% seed 42", 2, in, nothing));
  EXPECT_TRUE(a == run("delay 20ms 15ms loss 10%", 42, in, nothing));
}

TEST(ShimDeterminism, OneKnobDoesNotDisturbAnother) {
  // The same packets are lost whatever else happens to those that are not.
  const auto survivors = [](const char* spec) {
    Shim shim(shell::parse_netem(spec), testing::seed());
    std::vector<std::uint32_t> numbers;
    for (const Out& o : testing::stream(shim, 10'000, 1'000)) numbers.push_back(o.number);
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  };
  const auto plain = survivors("loss 10%");
  EXPECT_EQ(plain, survivors("loss 10% delay 50ms 40ms reorder 10%"));
  EXPECT_EQ(plain, survivors("loss 10% rate 10mbit slot 5ms 9ms"));
}

/// The outcome of one known case to the bit: the same for every compiler, at every optimisation, on every machine.
/// It changes when netem's rules, the streams or the tables do, and then says so here.
TEST(ShimDeterminism, GoldenOutcome) {
  Hasher hash;
  const auto in = arrivals(1);
  for (const char* spec : kSpecs) {
    const Outcome o = run(spec, 1, in, [](Shim&, Micros, Micros, std::vector<Bytes>&) {});
    for (const Bytes& b : o.out) {
      hash.add(std::uint64_t{b.size()});
      for (const std::byte x : b) hash.add(std::uint64_t{std::to_integer<std::uint8_t>(x)});
    }
    hash.add(o.stats.lost);
    hash.add(o.stats.reordered);
  }
  EXPECT_EQ(hash.value(), 11217957826035319199ULL);
}

}  // namespace
}  // namespace padr::link
