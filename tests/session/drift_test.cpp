#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/link/shim.h"
#include "common/participant/session.h"
#include "common/replica/replica.h"
#include "tests/seed.h"
#include "tests/session/virtual_net.h"
#include "tests/world/test_scene.h"

namespace padr::test {
namespace {

/// A peer with a clock of its own, doing with session and replica what padr-peer's event loop does.
struct Drifter {
  int n = 0;         ///< its place; its clock is n hours off
  double drift = 0;  ///< of its clock, parts of 1
  Micros born = 0;   ///< when its program is started
  std::unique_ptr<node::Session> session;
  std::unique_ptr<node::Replica> replica;
  Tick steered = 0;
  Micros last_session = 0;  ///< what the session clock showed last
  Micros last_local = 0;

  Micros local(Micros now) const {
    return now + n * 3'600'000'000LL + static_cast<Micros>(std::floor(static_cast<double>(now) * drift));
  }
};

class DriftingNet {
 public:
  DriftingNet(std::uint64_t seed, const std::string& netem) : seed_(seed), spec_(link::parse_netem(netem)) {}

  void add(double drift, Micros born) {
    Drifter d;
    d.n = static_cast<int>(drifters_.size()) + 1;
    d.drift = drift;
    d.born = born;
    drifters_.push_back(std::move(d));
  }

  void run(Micros until) {
    constexpr Micros kStep = 1000;
    for (; now_ < until; now_ += kStep) {
      for (Drifter& d : drifters_) wake(d);
      for (auto& [ends, s] : shims_)
        while (const auto datagram = s->release(now_)) receive(ends.first, ends.second, *datagram);
      if (now_ >= judged_from) measure();
    }
  }

  Micros judged_from = 0;   ///< differences are taken from then on
  Micros worst_spread = 0;  ///< largest difference between two session clocks, us
  double worst_slew = 0;    ///< that any session clock was set to, parts of 1
  double worst_rate = 0;    ///< of any session clock against its local one, parts of 1 off, over a millisecond
  bool went_back = false;   ///< some session clock did
  Tick played = 0;          ///< of the peer that has played the least
  Tick widest_ticks = 0;    ///< largest difference between two peers' ticks

 private:
  void wake(Drifter& d) {
    if (now_ < d.born) return;
    const Micros local = d.local(now_);
    if (!d.session) d.session = std::make_unique<node::Session>(config_of(d), local);
    if (local >= d.session->next_due()) d.session->advance(local);
    for (const auto& out : d.session->take_outgoing()) send(d.n, out.to.address[15], out.bytes);
    if (d.session->phase() != node::SessionPhase::kStarted) return;
    if (!d.replica) {
      node::ReplicaConfig c;
      c.self = d.session->self();
      c.peers = static_cast<int>(d.session->beginners().size());
      c.slots = d.session->slots();
      c.session = d.session->number();
      d.replica = std::make_unique<node::Replica>(scene_, c);
      d.last_local = local;
      d.last_session = d.session->session_now(local);
    }
    watch(d, local);
    while (d.session->session_now(local) >= tick_start(d.replica->now() + 1)) {
      d.replica->step(scene_.avatar.spawns[d.replica->self()]);
      for (const node::Outgoing& o : d.replica->outgoing()) send(d.n, place_of(o.to), o.bytes);
    }
    constexpr Tick kSteerEvery = kTicksPerSecond / 2;
    if (d.replica->now() - d.steered < kSteerEvery) return;
    d.steered = d.replica->now();
    d.session->steer(local, d.replica->self() > 0 ? d.replica->clock_lead() : 0);
  }

  void watch(Drifter& d, Micros local) {
    const Micros session = d.session->session_now(local);
    went_back = went_back || session < d.last_session;
    const auto passed = static_cast<double>(local - d.last_local);
    // Until tick 0 the clock is set as answers come in. 2 us are what rounding makes of it.
    if (passed > 0 && d.last_session >= 0)
      worst_rate =
          std::max(worst_rate, (std::abs(static_cast<double>(session - d.last_session) - passed) - 2) / passed);
    worst_slew = std::max(worst_slew, std::abs(d.session->clock().slew()));
    d.last_session = session;
    d.last_local = local;
  }

  node::SessionConfig config_of(const Drifter& d) const {
    node::SessionConfig c = alike(seed_ + static_cast<std::uint64_t>(d.n));
    c.wanted = c.slots = static_cast<int>(drifters_.size());
    if (d.n > 1) c.join = place(1);
    return c;
  }

  int place_of(PeerId p) const {
    for (const Drifter& d : drifters_)
      if (d.session && d.session->self() == p) return d.n;
    return 0;
  }

  void send(int from, int to, std::span<const std::byte> bytes) {
    auto& s = shims_[{from, to}];
    if (!s)
      s = std::make_unique<link::Shim>(
          spec_, seed_ * 1000 + static_cast<std::uint64_t>(from) * 10 + static_cast<std::uint64_t>(to));
    s->accept(now_, bytes);
  }

  void receive(int from, int to, std::span<const std::byte> bytes) {
    Drifter& d = drifters_[static_cast<std::size_t>(to) - 1];
    if (!d.session) return;
    const Micros local = d.local(now_);
    wire::SealError refused{};
    const auto opened = wire::open(bytes, refused);
    ASSERT_TRUE(opened);
    if (d.session->receive(place(from), *opened, local) && d.replica)
      d.replica->receive(*opened, d.session->session_now(local));
  }

  void measure() {
    Micros lo = std::numeric_limits<Micros>::max();
    Micros hi = std::numeric_limits<Micros>::min();
    Tick first = std::numeric_limits<Tick>::max();
    Tick last = 0;
    for (const Drifter& d : drifters_) {
      const Micros t = d.session->session_now(d.local(now_));
      lo = std::min(lo, t);
      hi = std::max(hi, t);
      first = std::min(first, d.replica ? d.replica->now() : 0);
      last = std::max(last, d.replica ? d.replica->now() : 0);
    }
    worst_spread = std::max(worst_spread, hi - lo);
    widest_ticks = std::max(widest_ticks, last - first);
    played = first;
  }

  std::uint64_t seed_;
  link::NetemSpec spec_;
  Scene scene_ = busy_scene(1, 0);
  Micros now_ = 0;
  std::vector<Drifter> drifters_;
  std::map<std::pair<int, int>, std::unique_ptr<link::Shim>> shims_;
};

// Clocks that are hours apart and drift by as much as cheap quartz does, programs that start seconds apart, a jittery
// link: for ten minutes.
TEST(Drift, SessionTicksStayWithinOneTick) {
  const std::uint64_t seed = test::seed(1);
  for (const auto& drifts : {std::array{200e-6, -200e-6, 0.0}, std::array{-200e-6, 200e-6, 200e-6}}) {
    DriftingNet net(seed, "delay 50ms 20ms");
    net.add(drifts[0], 0);
    net.add(drifts[1], 3 * kMicrosPerSecond);
    net.add(drifts[2], 7 * kMicrosPerSecond);
    net.judged_from = 15 * kMicrosPerSecond;
    net.run(net.judged_from + 600 * kMicrosPerSecond);
    std::cout << "drifts " << drifts[0] * 1e6 << ", " << drifts[1] * 1e6 << ", " << drifts[2] * 1e6
              << " ppm: clocks within " << static_cast<double>(net.worst_spread) / 1000 << " ms, ticks within "
              << net.widest_ticks << ", slew up to " << net.worst_slew * 1e6 << " ppm, " << net.played << " ticks\n";
    EXPECT_GT(net.played, 600 * kTicksPerSecond);
    EXPECT_LE(net.worst_spread, kMicrosPerSecond / kTicksPerSecond) << "a tick";
    EXPECT_LE(net.widest_ticks, 1);
    EXPECT_FALSE(net.went_back);
    EXPECT_LE(net.worst_rate, node::SessionClock::kMaxSlew);
    EXPECT_LE(net.worst_slew, node::SessionClock::kMaxSlew);
    EXPECT_GT(net.worst_slew, 200e-6) << "or nothing was followed";
  }
}

}  // namespace
}  // namespace padr::test
