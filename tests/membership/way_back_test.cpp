// Whether there is a reason to join anew: a question, which may be asked at any time or never.
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "common/membership/membership.h"
#include "tests/world/test_scene.h"

namespace padr::test {
namespace {

/// Three peers beside one another, of whom the second is looked at.
class Trio {
 public:
  Trio() {
    for (PeerId p = 0; p < 3; ++p) {
      node::ReplicaConfig c;
      c.self = p;
      c.peers = c.slots = 3;
      nodes_[p] = std::make_unique<node::RecordedReplica>(scene_, c);
    }
    session_.self = 1;
    session_.slots = 3;
    for (PeerId p = 0; p < 3; ++p) nodes_[1]->locate(p, ipv4({10, 0, 0, static_cast<std::uint8_t>(p + 1)}, 7000));
    membership_ = std::make_unique<node::Membership>(session_, *nodes_[1]);
  }
  /// The first `speaking` peers go on, and hear one another.
  void run_to(Tick until, PeerId speaking) {
    while (++now_ <= until) {
      for (PeerId p = 0; p < speaking; ++p) nodes_[p]->step({});
      membership_->advance(tick_start(now_));
      for (PeerId p = 0; p < speaking; ++p)
        for (const node::Outgoing& o : nodes_[p]->outgoing())
          if (o.to < speaking) nodes_[o.to]->receive(o.bytes, tick_start(now_));
    }
    --now_;
  }
  node::Membership& membership() { return *membership_; }
  const Endpoint& first() const { return nodes_[1]->replica().seat(0).at; }
  node::SessionState& state() { return session_; }
  Tick confirmed() const { return nodes_[1]->replica().agreed().confirmed().tick; }

 private:
  Scene scene_ = busy_scene(1, 0);
  std::array<std::unique_ptr<node::RecordedReplica>, 3> nodes_;
  node::SessionState session_;
  std::unique_ptr<node::Membership> membership_;
  Tick now_ = 0;
};

// The first never declares the third gone, so nothing is confirmed any more.
TEST(WayBack, WhatIsStuckIsStuckWhetherAnybodyHasAskedOrNot) {
  Trio trio;
  trio.run_to(120, 3);
  trio.run_to(180, 2);
  const Tick stuck = trio.confirmed() + 12 * kTicksPerSecond;
  trio.run_to(stuck - 30, 2);
  ASSERT_LT(trio.confirmed(), 180);
  EXPECT_FALSE(trio.membership().way_back());
  trio.run_to(stuck + 30, 2);
  EXPECT_EQ(trio.membership().way_back(), trio.first());

  Trio unasked;
  unasked.run_to(120, 3);
  unasked.run_to(stuck + 30, 2);
  unasked.state().events.clear();
  EXPECT_EQ(unasked.membership().way_back(), unasked.first());
  EXPECT_TRUE(unasked.state().events.empty()) << "asking says nothing";
  unasked.membership().announce_way_back();
  unasked.membership().announce_way_back();
  ASSERT_EQ(unasked.state().events.size(), 1U);
  EXPECT_EQ(unasked.state().events[0].kind, node::SessionEvent::Kind::kReturning);
  EXPECT_EQ(unasked.state().events[0].text, "nothing has been confirmed for 12 s");
}

// The third goes on for a moment every 10 s, so a little is confirmed now and then.
TEST(WayBack, WhoConfirmsNowAndThenButIsFarBehindIsStuck) {
  Trio trio;
  trio.run_to(120, 3);
  Tick now = 120;
  const auto crawl_until = [&](Tick until) {
    while (now < until) {
      trio.run_to(now += 580, 2);
      trio.run_to(now += 20, 3);
    }
  };
  crawl_until(1320);
  EXPECT_GT(trio.confirmed(), 120) << "something is confirmed now and then";
  EXPECT_FALSE(trio.membership().way_back());
  crawl_until(1920);
  EXPECT_EQ(trio.membership().way_back(), trio.first());
}

}  // namespace
}  // namespace padr::test
