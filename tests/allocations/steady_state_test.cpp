#include <gtest/gtest.h>

#include "tests/bench/party.h"

namespace padr::bench {
namespace {

// Longer than any history that is kept, so that every place of it has been written to.
constexpr int kWarmUp = 12 * kTicksPerSecond;
constexpr int kFrames = 10 * kTicksPerSecond;

/// By the first one's frames, in all of them.
std::uint64_t allocations_of(Party& party) {
  for (int i = 0; i < kWarmUp; ++i) party.tick();
  std::uint64_t sum = 0;
  for (int i = 0; i < kFrames; ++i) sum += party.tick().allocations;
  return sum;
}

// Marks, acknowledgements and hashes come and go. (An update is kept until everybody has it, and that takes memory.)
TEST(SteadyState, WithoutUpdatesNothingIsAllocated) {
  Party party(room(60, 4), 4, "delay 100ms loss 2%", "rest");
  EXPECT_EQ(allocations_of(party), 0U);
}

}  // namespace
}  // namespace padr::bench
