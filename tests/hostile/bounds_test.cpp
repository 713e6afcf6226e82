// What anybody can make a peer keep: the parts that keep it, each alone.
#include <gtest/gtest.h>

#include "common/membership/admissions.h"
#include "common/membership/partition_merge.h"
#include "common/scenarios/scenarios.h"
#include "common/session/applied_commands.h"

namespace padr::node {
namespace {

constexpr int kSlots = 4;

ReplicaConfig alone() {
  ReplicaConfig c;
  c.slots = kSlots;
  return c;
}

SessionState state_of_a_member() {
  SessionState state;
  state.self = 0;
  state.slots = state.wanted = kSlots;
  return state;
}

Endpoint place(std::uint16_t n) {
  return ipv4({10, 0, 0, 1}, static_cast<std::uint16_t>(1000 + n));
}

// Each has a slot promised to it, and takes as long as a guest may.
TEST(Bounds, NewcomersAreAsManyAsThereAreSlotsAndAreForgotten) {
  SessionState state = state_of_a_member();
  RecordedReplica replica(scenarios::load_embedded("ball", 1), alone());
  AppliedCommands out(state, replica);
  Admissions admissions(state);
  Micros now = 0;
  for (std::uint16_t n = 0; n < 1000; ++n) {
    now += 40'000;  // as often as anybody is answered
    admissions.on_join(place(n), {n + 1U, 0, 0, true, ""}, view_of(replica.replica()), now, out);
    admissions.on_pull(
        place(n), {n + 1U, 0, ~std::uint64_t{0}}, [] { return sync::Transfer{}; }, now, out);
    admissions.advance(now);
    EXPECT_LE(admissions.guests(), std::size_t{kSlots - 1});
    state.outgoing.clear();
  }
  EXPECT_EQ(admissions.guests(), std::size_t{kSlots - 1});
  admissions.advance(now + 60 * kMicrosPerSecond);
  EXPECT_EQ(admissions.guests(), 0U);
}

TEST(Bounds, OfThoseWhoAreGoneTheLatestAreRememberedForAWhile) {
  SessionState state = state_of_a_member();
  PartitionMerge sides(state);
  for (std::uint16_t n = 0; n < 1000; ++n) sides.remember({place(n), 1, 1}, 1);
  ASSERT_EQ(sides.gone().size(), PartitionMerge::kMost);
  EXPECT_EQ(sides.gone().back().at, place(999));
  EXPECT_EQ(sides.gone().front().at, place(1000 - PartitionMerge::kMost));
  RecordedReplica replica(scenarios::load_embedded("ball", 1), alone());
  AppliedCommands out(state, replica);
  while (replica.replica().now() <= PartitionMerge::kRemember) replica.step({});
  sides.advance(view_of(replica.replica()), out);
  EXPECT_EQ(sides.gone().size(), PartitionMerge::kMost);
  for (Tick t = 0; t <= PartitionMerge::kPace; ++t) replica.step({});
  sides.advance(view_of(replica.replica()), out);
  EXPECT_TRUE(sides.gone().empty());
}

}  // namespace
}  // namespace padr::node
