// What anybody can make a peer keep: the parts that keep it, each alone.
#include <gtest/gtest.h>

#include "common/node/doorkeeper.h"
#include "common/node/sides.h"
#include "common/scenarios/scenarios.h"

namespace padr::node {
namespace {

constexpr int kSlots = 4;

NodeConfig alone() {
  NodeConfig c;
  c.slots = kSlots;
  return c;
}

SessionDesk desk_of_a_member() {
  SessionDesk desk;
  desk.self = 0;
  desk.slots = desk.wanted = kSlots;
  desk.roster.resize(kSlots);
  return desk;
}

Endpoint place(std::uint16_t n) {
  return ipv4({10, 0, 0, 1}, static_cast<std::uint16_t>(1000 + n));
}

// Each has a slot promised to it, and takes as long as a guest may.
TEST(Bounds, NewcomersAreAsManyAsThereAreSlotsAndAreForgotten) {
  SessionDesk desk = desk_of_a_member();
  const RecordedNode node(scenarios::load_embedded("ball", 1), alone());
  Doorkeeper doorkeeper(desk);
  Micros now = 0;
  for (std::uint16_t n = 0; n < 1000; ++n) {
    now += 40'000;  // as often as anybody is answered
    doorkeeper.on_join(place(n), {n + 1U, 0, 0, true, ""}, node, now);
    doorkeeper.on_pull(place(n), {n + 1U, 0, ~std::uint64_t{0}}, node, {});
    doorkeeper.advance(now);
    EXPECT_LE(doorkeeper.guests(), std::size_t{kSlots - 1});
    desk.outgoing.clear();
  }
  EXPECT_EQ(doorkeeper.guests(), std::size_t{kSlots - 1});
  doorkeeper.advance(now + 60 * kMicrosPerSecond);
  EXPECT_EQ(doorkeeper.guests(), 0U);
}

TEST(Bounds, OfThoseWhoAreGoneTheLatestAreRememberedForAWhile) {
  SessionDesk desk = desk_of_a_member();
  Sides sides(desk);
  for (std::uint16_t n = 0; n < 1000; ++n) sides.remember(place(n), 1);
  ASSERT_EQ(sides.gone().size(), Sides::kMost);
  EXPECT_EQ(sides.gone().back(), place(999));
  EXPECT_EQ(sides.gone().front(), place(1000 - Sides::kMost));
  RecordedNode node(scenarios::load_embedded("ball", 1), alone());
  while (node.node().now() <= Sides::kRemember) node.step({});
  sides.advance(node.node());
  EXPECT_EQ(sides.gone().size(), Sides::kMost);
  for (Tick t = 0; t <= Sides::kPace; ++t) node.step({});
  sides.advance(node.node());
  EXPECT_TRUE(sides.gone().empty());
}

}  // namespace
}  // namespace padr::node
