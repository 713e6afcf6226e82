#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

constexpr int kPeers = 3;

/// What clocks did, from some time on.
struct Clocks {
  Micros spread = 0;       ///< largest difference between two session clocks, us
  double slew = 0;         ///< that any session clock was set to, parts of 1
  bool went_back = false;  ///< some session clock did
  Tick ticks = 0;          ///< largest difference between two peers' ticks
  std::array<Micros, kPeers> last{};

  void look(const Party& party) {
    Micros lo = party.net().session_now(0);
    Micros hi = lo;
    Tick first = party.replica(0).now();
    Tick end = first;
    for (int p = 0; p < kPeers; ++p) {
      const Micros t = party.net().session_now(p);
      went_back |= t < last[static_cast<std::size_t>(p)];
      last[static_cast<std::size_t>(p)] = t;
      lo = std::min(lo, t);
      hi = std::max(hi, t);
      first = std::min(first, party.replica(p).now());
      end = std::max(end, party.replica(p).now());
      slew = std::max(slew, std::abs(party.net().peer(p).session().clock().slew()));
    }
    spread = std::max(spread, hi - lo);
    ticks = std::max(ticks, end - first);
  }
};

// Clocks that are hours apart and drift by as much as cheap quartz does, programs that start seconds apart, a jittery
// link: for ten minutes.
TEST(Drift, SessionTicksStayWithinOneTick) {
  const std::uint64_t seed = test::seed(1);
  for (const auto& drifts : {std::array{200.0, -200.0, 0.0}, std::array{-200.0, 200.0, 200.0}}) {
    lab::VirtualNetworkConfig config = party_config(kPeers, "delay 50ms 20ms", seed, 1);
    config.ppm = [&drifts](int person) { return drifts[static_cast<std::size_t>(person)]; };
    Party party(config, {}, 1);
    for (const double pause : {3.0, 4.0}) {
      party.run(pause);
      party.net().start(0);
    }
    party.run(8);
    Clocks clocks;
    for (int i = 0; i < 600 * 10; ++i) {
      party.run(0.1);
      clocks.look(party);
    }
    std::cout << "drifts " << drifts[0] << ", " << drifts[1] << ", " << drifts[2] << " ppm: clocks within "
              << static_cast<double>(clocks.spread) / 1000 << " ms, ticks within " << clocks.ticks << ", slew up to "
              << clocks.slew * 1e6 << " ppm\n";
    EXPECT_GT(party.replica(0).now(), 600 * kTicksPerSecond);
    EXPECT_LE(clocks.spread, kMicrosPerSecond / kTicksPerSecond) << "a tick";
    EXPECT_LE(clocks.ticks, 1);
    EXPECT_FALSE(clocks.went_back);
    EXPECT_LE(clocks.slew, node::SessionClock::kMaxSlew);
    EXPECT_GT(clocks.slew, 200e-6) << "or nothing was followed";
    EXPECT_EQ(party.judge().violation(), "");
  }
}

}  // namespace
}  // namespace padr::test
