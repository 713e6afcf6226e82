#include "tools/monitor/order_desk.h"

#include <gtest/gtest.h>

namespace padr::monitor {
namespace {

/// Two peers that take orders, and what is sent to them.
struct Desk {
  Desk() {
    for (const std::uint64_t process : {11U, 12U}) {
      peers.emplace_back(Origin{process, 1, static_cast<PeerId>(process - 11), 0});
      peers.back().from.port = static_cast<std::uint16_t>(process);
      peers.back().hello.emplace();
      peers.back().hello->control = true;
      peers.back().hello->token = process * 100;
    }
  }
  std::vector<Order> sent(Micros now) {
    orders.clear();
    desk.advance(now);
    return orders;
  }
  Event answer(const Order& o, EventKind kind = EventKind::kKnob, std::string text = "") {
    return {1, 0, kind, kNoEntity, kNoPeer, o.number, std::move(text)};
  }

  std::vector<PeerRecord> peers;
  std::vector<Order> orders;
  OrderDesk desk{77, [this](const Endpoint& to, const Bytes& datagram) {
                   const auto order = decode_order(datagram);
                   ASSERT_TRUE(order);
                   EXPECT_EQ(to.port, order->process);
                   EXPECT_EQ(order->token, order->process * 100);
                   EXPECT_EQ(order->issuer, 77U);
                   orders.push_back(*order);
                 }};
};

const Knob kKnob{"threshold", "0.5"};

TEST(OrderDesk, AnOrderIsSentUntilItIsAnswered) {
  Desk d;
  ASSERT_TRUE(d.desk.give({&d.peers[0]}, kKnob, {5, 9, "knob"}));
  const auto first = d.sent(0);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].what, What(kKnob));
  EXPECT_TRUE(d.sent(OrderDesk::kAgain - 1).empty());
  const auto again = d.sent(OrderDesk::kAgain);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].number, first[0].number) << "the same order";
  d.desk.heard(12, d.answer(first[0]));
  EXPECT_TRUE(d.desk.take_outcomes().empty()) << "somebody else's answer";
  d.desk.heard(11, d.answer(first[0]));
  const auto outcomes = d.desk.take_outcomes();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_TRUE(outcomes[0].ok);
  EXPECT_EQ(outcomes[0].ticket.viewer, 5U);
  EXPECT_EQ(outcomes[0].ticket.id, 9U);
  EXPECT_TRUE(d.sent(10 * OrderDesk::kAgain).empty());
}

TEST(OrderDesk, OrdersToAPeerGoOneAfterTheOther) {
  Desk d;
  ASSERT_TRUE(d.desk.give({&d.peers[0]}, kKnob, {}));
  ASSERT_TRUE(d.desk.give({&d.peers[0]}, Pause{1}, {}));
  const auto first = d.sent(0);
  ASSERT_EQ(first.size(), 1U);
  d.desk.heard(11, d.answer(first[0]));
  const auto second = d.sent(1);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].what, What(Pause{1}));
  EXPECT_GT(second[0].number, first[0].number);
}

TEST(OrderDesk, AllMustFollow) {
  Desk d;
  ASSERT_TRUE(d.desk.give({&d.peers[0], &d.peers[1]}, kKnob, {5, {}, "knob"}));
  const auto sent = d.sent(0);
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_NE(sent[0].number, sent[1].number);
  d.desk.heard(11, d.answer(sent[0]));
  EXPECT_TRUE(d.desk.take_outcomes().empty());
  d.desk.heard(12, d.answer(sent[1], EventKind::kRefused, "will not"));
  const auto outcomes = d.desk.take_outcomes();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_FALSE(outcomes[0].ok);
  EXPECT_EQ(outcomes[0].text, "peer 1: will not");
}

TEST(OrderDesk, ForOneThoseWhoRefuseAreFollowedByTheNext) {
  Desk d;
  const Push push{3, {4, 0}};
  ASSERT_TRUE(d.desk.give({&d.peers[0], &d.peers[1]}, push, {5, 9, "push"}, OrderDesk::Whom::kOne));
  const auto first = d.sent(0);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].process, 11U);
  d.desk.heard(11, d.answer(first[0], EventKind::kRefused, "another peer holds it"));
  EXPECT_TRUE(d.desk.take_outcomes().empty());
  const auto second = d.sent(1);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].process, 12U);
  EXPECT_EQ(second[0].what, What(push));
  d.desk.heard(12, d.answer(second[0], EventKind::kPush));
  const auto outcomes = d.desk.take_outcomes();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_TRUE(outcomes[0].ok);
  EXPECT_EQ(outcomes[0].text, "");
}

TEST(OrderDesk, ForOneItFailsIfAllRefuse) {
  Desk d;
  ASSERT_TRUE(d.desk.give({&d.peers[0], &d.peers[1]}, Push{3, {4, 0}}, {5, 9, "push"}, OrderDesk::Whom::kOne));
  d.desk.heard(11, d.answer(d.sent(0).at(0), EventKind::kRefused, "no"));
  d.desk.heard(12, d.answer(d.sent(1).at(0), EventKind::kRefused, "nor I"));
  const auto outcomes = d.desk.take_outcomes();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_FALSE(outcomes[0].ok);
  EXPECT_EQ(outcomes[0].text, "peer 0: no; peer 1: nor I");
  EXPECT_TRUE(d.sent(kMicrosPerSecond).empty());
}

TEST(OrderDesk, ForOneNobodyElseIsAskedInPlaceOfOneThatDoesNotAnswer) {
  Desk d;
  ASSERT_TRUE(d.desk.give({&d.peers[0], &d.peers[1]}, Push{3, {4, 0}}, {5, 9, "push"}, OrderDesk::Whom::kOne));
  for (Micros t = 0; t < 10 * kMicrosPerSecond; t += 10'000)
    for (const Order& o : d.sent(t)) EXPECT_EQ(o.process, 11U) << "it may have followed, and its answer is lost";
  const auto outcomes = d.desk.take_outcomes();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0].text, "peer 0: does not answer");
}

TEST(OrderDesk, WhoDoesNotAnswerIsGivenUp) {
  Desk d;
  ASSERT_TRUE(d.desk.give({&d.peers[0]}, kKnob, {5, {}, "knob"}));
  int sent = 0;
  for (Micros t = 0; t < 10 * kMicrosPerSecond; t += 10'000) sent += static_cast<int>(d.sent(t).size());
  EXPECT_EQ(sent, OrderDesk::kTries);
  const auto outcomes = d.desk.take_outcomes();
  ASSERT_EQ(outcomes.size(), 1U);
  EXPECT_EQ(outcomes[0].text, "peer 0: does not answer");
}

TEST(OrderDesk, WhatWaitsForAPeerIsBounded) {
  Desk d;
  for (std::size_t i = 0; i < OrderDesk::kWaiting; ++i) ASSERT_TRUE(d.desk.give({&d.peers[0]}, kKnob, {}));
  EXPECT_FALSE(d.desk.give({&d.peers[1], &d.peers[0]}, kKnob, {}));
  EXPECT_EQ(d.sent(0).size(), 1U) << "and the other has got nothing of it";
}

TEST(OrderDesk, ADriveIsRepeatedAndOnlyTheNewestCounts) {
  Desk d;
  const Drive east{Drive::Kind::kDirection, {1, 0}};
  const Drive north{Drive::Kind::kDirection, {0, 1}};
  d.desk.drive(d.peers[0], east);
  const auto first = d.sent(0);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_TRUE(d.sent(OrderDesk::kDriveAgain - 1).empty());
  ASSERT_EQ(d.sent(OrderDesk::kDriveAgain).size(), 1U);
  EXPECT_GT(d.orders[0].number, first[0].number) << "a peer takes only newer orders";
  d.desk.drive(d.peers[0], north);
  ASSERT_EQ(d.sent(OrderDesk::kDriveAgain + 1).size(), 1U) << "something new goes at once";
  EXPECT_EQ(d.orders[0].what, What(north));
  d.desk.drive(d.peers[0], {});
  const auto release = d.sent(OrderDesk::kDriveAgain + 2);
  ASSERT_EQ(release.size(), 1U);
  EXPECT_EQ(release[0].what, What(Drive{}));
  d.desk.heard(11, d.answer(release[0], EventKind::kDriveEnd));
  EXPECT_TRUE(d.sent(kMicrosPerSecond).empty());
}

// Once, such orders went on for as long as the monitor ran, and the peer went on following them.
TEST(OrderDesk, NobodyIsDrivenOnWhenAnotherSessionIsShown) {
  Desk d;
  d.desk.drive(d.peers[0], {Drive::Kind::kDirection, {1, 0}});
  ASSERT_EQ(d.sent(0).size(), 1U);
  d.desk.release_all();
  const auto release = d.sent(1);
  ASSERT_EQ(release.size(), 1U);
  EXPECT_EQ(release[0].what, What(Drive{}));
  d.desk.heard(11, d.answer(release[0], EventKind::kDriveEnd));
  EXPECT_TRUE(d.sent(kMicrosPerSecond).empty());
}

TEST(OrderDesk, WhoseSlotHasGoneToAnotherProcessIsDrivenNoMore) {
  Desk d;
  const Drive east{Drive::Kind::kDirection, {1, 0}};
  d.desk.drive(d.peers[0], east);
  ASSERT_EQ(d.sent(0).size(), 1U);
  d.peers[1].origin.slot = 0;
  d.desk.drive(d.peers[1], east);
  const auto sent = d.sent(OrderDesk::kDriveAgain);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].process, 12U);
}

TEST(OrderDesk, ADoubtIsToldIfAllFollow) {
  for (const EventKind kind : {EventKind::kNetem, EventKind::kRefused}) {
    Desk d;
    ASSERT_TRUE(d.desk.give({&d.peers[0]}, Netem{kNoPeer, "limit 0"}, {5, 9, "netem", "limit 0 drops"}));
    d.desk.heard(11, d.answer(d.sent(0).at(0), kind, "no"));
    const auto outcomes = d.desk.take_outcomes();
    ASSERT_EQ(outcomes.size(), 1U);
    EXPECT_EQ(outcomes[0].text, outcomes[0].ok ? "limit 0 drops" : "peer 0: no");
  }
}

}  // namespace
}  // namespace padr::monitor
