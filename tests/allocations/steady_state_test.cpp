#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

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

// Marks, acknowledgements and hashes come and go.
TEST(SteadyState, WithoutUpdatesNothingIsAllocated) {
  Party party(room(60, 4), 4, "delay 100ms loss 2%", "rest");
  EXPECT_EQ(allocations_of(party), 0U);
}

// Updates are told, kept, sent again and forgotten. What a tick needs is there from before, but for records: the most
// contacts, updates or bodies at once that there have ever been.
TEST(SteadyState, PlayAllocatesForRecordsAlone) {
  constexpr int kMinute = 60 * kTicksPerSecond;
  Party party(room(60, 4), 4, "delay 100ms loss 2%", "wander");
  for (int i = 0; i < 4 * kMinute; ++i) party.tick();
  const std::uint64_t told = party.first().stats().bundles;
  std::vector<std::uint64_t> by_window;
  std::uint64_t sum = 0;
  for (int window = 0; window < 25; ++window) {
    by_window.push_back(0);
    for (int i = 0; i < kFrames; ++i) by_window.back() += party.tick().allocations;
    sum += by_window.back();
  }
  EXPECT_GT(party.first().stats().bundles, told + 300);
  std::sort(by_window.begin(), by_window.end());
  EXPECT_EQ(by_window[by_window.size() / 2], 0U) << "most of ten seconds' frames allocate nothing at all";
  EXPECT_LT(static_cast<double>(sum), 25.0 * kFrames / 10);
}

}  // namespace
}  // namespace padr::bench
