#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/rng.h"
#include "peer/egress.h"
#include "shell/netem_text.h"
#include "tests/seed.h"

namespace padr::peer {
namespace {

using link::NetemSpec;
using link::Shim;

std::vector<std::byte> text(char c) {
  return std::vector<std::byte>(8, static_cast<std::byte>(c));
}

/// A shim that lets pass what may, beside one that always takes it in: what comes out has to be the same.
class Twins {
 public:
  Twins(const NetemSpec& spec, std::uint64_t seed) : direct_(spec, seed), queued_(spec, seed) {}

  void send(Micros now, std::span<const std::byte> datagram) {
    if (direct_.pass(now, datagram)) {
      ++passed_;
      out_.emplace_back(datagram.begin(), datagram.end());
    } else {
      direct_.accept(now, datagram);
    }
    queued_.accept(now, datagram);
    collect(now);
  }
  void set_spec(Micros now, const NetemSpec& spec) {
    direct_.set_spec(now, spec);
    queued_.set_spec(now, spec);
  }
  void collect(Micros now) {
    while (const auto d = direct_.release(now)) out_.push_back(*d);
    while (const auto d = queued_.release(now)) expected_.push_back(*d);
    ASSERT_EQ(out_, expected_);
    ASSERT_EQ(direct_.stats(), queued_.stats());
    ASSERT_EQ(direct_.next_due(), queued_.next_due());
  }
  int passed() const { return passed_; }

 private:
  Shim direct_, queued_;
  std::vector<std::vector<std::byte>> out_, expected_;
  int passed_ = 0;
};

// Whatever the rules become afterwards: chance goes on as if nothing had been let pass.
TEST(Links, WhatPassesIsWhatWouldHaveComeOut) {
  const std::uint64_t seed = test::seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  const std::vector<std::string> rules{"",
                                       "delay 20ms 5ms loss 10%",
                                       "limit 3 delay 1ms",
                                       "reorder 25% gap 3 delay 4ms",
                                       "rate 1mbit duplicate 5%",
                                       "limit 5",
                                       "loss gemodel 5% 20%",
                                       "slot 3ms packets 2",
                                       "corrupt 10% seed 4"};
  Twins twins(shell::parse_netem(""), seed);
  Micros now = 0;
  for (int i = 0; i < 20'000; ++i) {
    now += rng.below(3'000);
    if (rng.chance(0.01)) twins.set_spec(now, shell::parse_netem(rng.chance(0.5) ? "" : rules[rng.below(9)]));
    twins.send(now, text(static_cast<char>('a' + i % 26)));
    if (testing::Test::HasFatalFailure()) return;
  }
  twins.collect(now + 60'000'000);
  EXPECT_GT(twins.passed(), 1'000);
  EXPECT_LT(twins.passed(), 19'000);
}

TEST(Links, AnImpairedLinkIsPumpedAndAFreeOneIsNot) {
  std::vector<std::pair<std::uint16_t, char>> sent;
  Egress::Specs specs;
  specs.by_peer[2] = shell::parse_netem("delay 10ms");
  Egress egress(std::move(specs), [&sent](const Endpoint& to, std::span<const std::byte> d) {
    sent.emplace_back(to.port, static_cast<char>(d[0]));
  });
  using Sent = std::vector<std::pair<std::uint16_t, char>>;
  const auto at = [](std::uint16_t port) { return ipv4({127, 0, 0, 1}, port); };
  egress.sit(0);
  egress.state(2, at(7002), text('a'), 0);
  egress.state(1, at(7001), text('b'), 0);
  egress.session(at(7003), text('c'), 0);
  EXPECT_EQ(sent, (Sent{{7001, 'b'}, {7003, 'c'}}));
  EXPECT_EQ(egress.next_due(), 10'000);
  egress.pump(9'999);
  EXPECT_EQ(sent.size(), 2U);
  egress.pump(10'000);
  EXPECT_EQ(sent.back(), (std::pair<std::uint16_t, char>{7002, 'a'}));
  EXPECT_FALSE(egress.next_due());
  EXPECT_EQ(egress.shim(1)->stats().released, 1U);
}

}  // namespace
}  // namespace padr::peer
