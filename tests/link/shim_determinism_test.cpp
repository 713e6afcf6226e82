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

constexpr const char* kTraceSpecs[] = {
    "trace 3,3,9,40 limit 7 loss 10%",
    "trace mobile 30s delay 5ms 9ms distribution normal duplicate 20% limit 20",
    "trace 1,2,2,50 random delay 4ms 9ms reorder 20% gap 2 loss gemodel 5% 20% corrupt 30%",
};

template <typename Run>
void with_each_spec(const Run& run) {
  for (const char* spec : kSpecs) run(spec);
  for (const char* spec : kTraceSpecs) run(spec);
}

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
  Shim shim(testing::parse(spec), seed);
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
  with_each_spec([&](const char* spec) {
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
  });
}

TEST(ShimDeterminism, SameSeedSameOutcomeOtherSeedOther) {
  const auto in = arrivals(testing::seed());
  const auto nothing = [](Shim&, Micros, Micros, std::vector<Bytes>&) {};
  with_each_spec([&](const char* spec) {
    SCOPED_TRACE(spec);
    const Outcome a = run(spec, 5, in, nothing);
    EXPECT_TRUE(a == run(spec, 5, in, nothing));
    if (*spec != '\0' && std::string_view(spec).find("slot distribution normal") == std::string_view::npos) {
      EXPECT_FALSE(a == run(spec, 6, in, nothing));
    }
  });
}

TEST(ShimDeterminism, SeedInTheSpecificationLeavesLinksApart) {
  const auto in = arrivals(testing::seed());
  const auto nothing = [](Shim&, Micros, Micros, std::vector<Bytes>&) {};
  const Outcome a = run("delay 20ms 15ms loss 10% seed 42", 1, in, nothing);
  EXPECT_TRUE(a == run("delay 20ms 15ms loss 10% seed 42", 1, in, nothing));
  EXPECT_FALSE(a == run("delay 20ms 15ms loss 10% seed 42", 2, in, nothing)) << "another link";
  EXPECT_FALSE(a == run("delay 20ms 15ms loss 10% seed 43", 1, in, nothing));
  EXPECT_FALSE(a == run("delay 20ms 15ms loss 10%", 1, in, nothing));
  const auto ordered = [&](const char* later) {
    return [&, later](Shim& shim, Micros, Micros, std::vector<Bytes>&) {
      if (shim.stats().accepted == 0) shim.set_spec(0, shell::parse_netem(later));
    };
  };
  EXPECT_FALSE(run("", 1, in, ordered("loss 10% seed 42")) == run("", 2, in, ordered("loss 10% seed 42")))
      << "ordered while it runs";
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
  EXPECT_EQ(plain, survivors("loss 10% trace uplink random limit 10000"));
}

/// The outcome of one known case to the bit: the same for every compiler, at every optimisation, on every machine.
/// It changes when netem's rules, the streams or the tables do, and then says so here.
TEST(ShimDeterminism, GoldenOutcome) {
  const auto in = arrivals(1);
  const auto hash_of = [&](std::span<const char* const> specs) {
    Hasher hash;
    for (const char* spec : specs) {
      const Outcome o = run(spec, 1, in, [](Shim&, Micros, Micros, std::vector<Bytes>&) {});
      for (const Bytes& b : o.out) {
        hash.add(std::uint64_t{b.size()});
        for (const std::byte x : b) hash.add(std::uint64_t{std::to_integer<std::uint8_t>(x)});
      }
      hash.add(o.stats.lost);
      hash.add(o.stats.reordered);
    }
    return hash.value();
  };
  EXPECT_EQ(hash_of(kSpecs), 11217957826035319199ULL);
  EXPECT_EQ(hash_of(kTraceSpecs), 17260305480393978371ULL);
}

}  // namespace
}  // namespace padr::link
