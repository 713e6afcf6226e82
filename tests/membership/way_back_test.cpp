// Whether there is a reason to join anew: a question, which may be asked at any time or never.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "common/membership/membership.h"
#include "tests/world/test_scene.h"

namespace padr::test {
namespace {

/// Peers beside one another, of whom one is looked at: the last but one unless told otherwise.
class Group {
 public:
  explicit Group(PeerId peers) : Group(peers, peers - 2) {}
  Group(PeerId peers, PeerId self) : nodes_(peers) {
    for (PeerId p = 0; p < peers; ++p) {
      node::ReplicaConfig c;
      c.self = p;
      c.peers = c.slots = peers;
      nodes_[p] = std::make_unique<node::RecordedReplica>(scene_, c);
    }
    session_.self = self;
    session_.slots = peers;
    for (PeerId p = 0; p < peers; ++p) own().locate(p, ipv4({10, 0, 0, static_cast<std::uint8_t>(p + 1)}, 7000));
    membership_ = std::make_unique<node::Membership>(session_, own());
  }
  /// These peers go on, and hear one another.
  void run_to(Tick until, const std::vector<PeerId>& speaking) {
    while (++now_ <= until) {
      for (const PeerId p : speaking) nodes_[p]->step({});
      for (const PeerId p : apart) nodes_[p]->step({});
      membership_->advance(tick_start(now_));
      for (const PeerId p : unheard) {
        own().freeze(p, true);
        if (shared_with) nodes_[*shared_with]->freeze(p, true);
      }
      for (const PeerId p : speaking)
        for (const node::Outgoing& o : nodes_[p]->outgoing())
          if (std::count(speaking.begin(), speaking.end(), o.to) > 0) nodes_[o.to]->receive(o.bytes, tick_start(now_));
    }
    --now_;
  }
  node::Membership& membership() { return *membership_; }
  const Endpoint& place(PeerId p) { return own().replica().seat(p).at; }
  node::SessionState& state() { return session_; }
  bool has_left() { return own().replica().roster().leaving; }
  /// These go on, but neither hear anybody nor are heard.
  std::vector<PeerId> apart;
  /// The peer that is looked at takes no updates of these.
  std::vector<PeerId> unheard;
  /// Nor does this one.
  std::optional<PeerId> shared_with;
  /// The peer that is looked at takes p for silent from now on.
  void give_up(PeerId p) { own().give_up(p, true); }
  Tick confirmed() { return own().replica().agreed().confirmed().tick; }

 private:
  node::RecordedReplica& own() { return *nodes_[session_.self]; }

  Scene scene_ = busy_scene(1, 0);
  std::vector<std::unique_ptr<node::RecordedReplica>> nodes_;
  node::SessionState session_;
  std::unique_ptr<node::Membership> membership_;
  Tick now_ = 0;
};

// The first never declares the third gone, so nothing is confirmed any more.
TEST(WayBack, WhatIsStuckIsStuckWhetherAnybodyHasAskedOrNot) {
  Group trio(3);
  trio.run_to(120, {0, 1, 2});
  trio.run_to(180, {0, 1});
  const Tick stuck = trio.confirmed() + 12 * kTicksPerSecond;
  trio.run_to(stuck - 30, {0, 1});
  ASSERT_LT(trio.confirmed(), 180);
  EXPECT_FALSE(trio.membership().way_back());
  trio.run_to(stuck + 30, {0, 1});
  EXPECT_EQ(trio.membership().way_back(), trio.place(0));

  Group unasked(3);
  unasked.run_to(120, {0, 1, 2});
  unasked.run_to(stuck + 30, {0, 1});
  unasked.state().events.clear();
  EXPECT_EQ(unasked.membership().way_back(), unasked.place(0));
  EXPECT_TRUE(unasked.state().events.empty()) << "asking says nothing";
  unasked.membership().announce_way_back();
  unasked.membership().announce_way_back();
  ASSERT_EQ(unasked.state().events.size(), 1U);
  EXPECT_EQ(unasked.state().events[0].kind, node::SessionEvent::Kind::kReturning);
  EXPECT_EQ(unasked.state().events[0].text, "nothing has been confirmed for 12 s");
}

// The third goes on for a moment every 10 s, so a little is confirmed now and then.
TEST(WayBack, WhoConfirmsNowAndThenButIsFarBehindIsStuck) {
  Group trio(3);
  trio.run_to(120, {0, 1, 2});
  Tick now = 120;
  const auto crawl_until = [&](Tick until) {
    while (now < until) {
      trio.run_to(now += 580, {0, 1});
      trio.run_to(now += 20, {0, 1, 2});
    }
  };
  crawl_until(1320);
  EXPECT_GT(trio.confirmed(), 120) << "something is confirmed now and then";
  EXPECT_FALSE(trio.membership().way_back());
  crawl_until(1920);
  EXPECT_EQ(trio.membership().way_back(), trio.place(0));
}

// Once, it was given up with whoever had coordinated before it, and this peer took itself for the coordinator.
TEST(WayBack, WhoCoordinatesNextHasAsLongToLetThisPeerIn) {
  Group four(4);
  four.state().config.sealed = true;
  four.run_to(120, {0, 1, 2, 3});
  four.unheard = {3};
  four.run_to(180, {0, 1, 2, 3});
  const Tick second = four.confirmed() + 21 * kTicksPerSecond;
  four.run_to(second - 3 * kTicksPerSecond, {0, 1, 2, 3});
  EXPECT_EQ(four.membership().way_back(), four.place(0));
  four.run_to(second + 7 * kTicksPerSecond, {1, 2, 3});
  EXPECT_EQ(four.membership().way_back(), four.place(1));
  four.run_to(second + 11 * kTicksPerSecond, {1, 2, 3});
  EXPECT_FALSE(four.membership().way_back()) << "the next one is this peer";
}

// Once, all joined anew by a coordinator that had admitted somebody who was nowhere, and confirmed nothing there
// either.
TEST(WayBack, ACoordinatorThatDoesNotAskAboutASilentPeerCountsAsSilentItself) {
  for (const bool sealed : {false, true}) {
    for (const bool asks : {false, true}) {
      SCOPED_TRACE(std::to_string(sealed) + std::to_string(asks));
      Group four(4);
      four.state().config.sealed = sealed;
      four.run_to(120, {0, 1, 2, 3});
      four.run_to(180, {0, 1, 2});
      const Tick stuck = four.confirmed() + 12 * kTicksPerSecond;
      for (Tick t = 180; t < stuck + kTicksPerSecond;) {
        four.run_to(t += 30, {0, 1, 2});
        EXPECT_TRUE(t > stuck || !four.membership().way_back());
        if (!asks || t < 120 + node::kSilence) continue;
        const wire::MembershipMessage poll = wire::Poll{{{3, 0, 0}}, true, 0};
        four.membership().receive(four.place(0), {wire::Kind::kMembership, 0, 0}, poll, wire::kMaxDatagram, 0);
      }
      EXPECT_EQ(four.membership().way_back(), four.place(sealed && !asks ? 1 : 0));
      four.run_to(stuck + 6 * kTicksPerSecond, {0, 1, 2});
      EXPECT_TRUE(four.membership().way_back()) << "the next one has as long to ask";
    }
  }
}

// Others had heard the silent one for a little longer. Once, the coordinator counted as silent for a minute all the
// same: its questions found no reply and its orders were refused, until it was cut off.
TEST(WayBack, ACoordinatorThatHasSparedASilentPeerIsFollowedAgainOnceSomethingIsConfirmed) {
  Group four(4);
  four.state().config.sealed = true;
  four.run_to(120, {0, 1, 2, 3});
  four.apart = {3};
  four.run_to(180, {0, 1, 2});
  const Tick stuck = four.confirmed() + 12 * kTicksPerSecond;
  four.run_to(stuck + kTicksPerSecond, {0, 1, 2});
  ASSERT_NE(four.membership().coordinator(), 0);
  four.apart.clear();
  four.run_to(stuck + 3 * kTicksPerSecond, {0, 1, 2, 3});
  ASSERT_GT(four.confirmed(), stuck);
  EXPECT_EQ(four.membership().coordinator(), 0);
}

// The last falls silent, and the others never say what they have of it, as if they followed another coordinator.
TEST(WayBack, ACoordinatorWhomNobodyFollowsLeavesItsSeatAndJoinsAnew) {
  Group four(4, 0);
  four.run_to(120, {0, 1, 2, 3});
  const Tick lost = 120 + node::kSilence;
  four.run_to(lost + node::Evictions::kWithheld - kTicksPerSecond, {0, 1, 2});
  EXPECT_FALSE(four.membership().way_back());
  EXPECT_FALSE(four.has_left());
  four.run_to(lost + node::Evictions::kWithheld + kTicksPerSecond, {0, 1, 2});
  EXPECT_TRUE(four.has_left());
  EXPECT_EQ(four.membership().way_back(), four.place(1));
  four.membership().announce_way_back();
  EXPECT_EQ(four.state().events.back().text, "none of the others follows this peer");
}

// Once, a coordinator never asked why it confirmed nothing, and stayed as it was.
TEST(WayBack, ACoordinatorThatIsStuckWhileAnotherMemberIsNotJoinsAnew) {
  Group trio(3, 0);
  trio.run_to(120, {0, 1, 2});
  trio.unheard = {2};
  const Tick stuck = 120 + 12 * kTicksPerSecond;
  trio.run_to(stuck - kTicksPerSecond, {0, 1, 2});
  EXPECT_FALSE(trio.has_left());
  trio.run_to(stuck + kTicksPerSecond, {0, 1, 2});
  EXPECT_TRUE(trio.has_left());
  EXPECT_EQ(trio.membership().way_back(), trio.place(1));
}

// Once, it waited for one whom it had cut off, and stayed in a world of its own.
TEST(WayBack, NobodyGoesBackByWhomItHasCutOff) {
  Group four(4, 0);
  four.run_to(120, {0, 1, 2, 3});
  four.state().config.sealed = true;  // or nobody would be cut off
  for (std::size_t n = 0; n < node::MisbehaviourPolicy::kNonsense; ++n)
    four.membership().on_drop(1, sync::DropReason::kMalformed, tick_start(120));
  four.state().config.sealed = false;  // or all would be, as none of them has a key
  four.unheard = {3};
  four.run_to(120 + 13 * kTicksPerSecond, {0, 1, 2, 3});
  EXPECT_TRUE(four.has_left());
  EXPECT_EQ(four.membership().way_back(), four.place(2));
}

// The coordinator before it had lied, and is about to be evicted. Once, the next one took that one's confirmed world
// for a reason to leave its seat; so did all others, one after the other.
TEST(WayBack, ACoordinatorThatIsStuckStaysIfTheMemberThatIsNotIsSilent) {
  for (const bool silent : {true, false}) {
    Group four(4, 0);
    four.run_to(120, {0, 1, 2, 3});
    four.unheard = {3};
    four.shared_with = 2;
    const Tick stuck = 120 + 12 * kTicksPerSecond;
    four.run_to(stuck - kTicksPerSecond, {0, 1, 2, 3});
    if (silent) four.give_up(1);
    four.run_to(stuck + kTicksPerSecond, {0, 1, 2, 3});
    EXPECT_NE(four.has_left(), silent);
  }
}

}  // namespace
}  // namespace padr::test
