#include "tools/capture/world_check.h"

#include <gtest/gtest.h>

namespace padr::capture {
namespace {

constexpr Tick kOut = 20;        ///< peer 2 is out from here on, in the world that stands
constexpr Tick kConfirmed = 30;  ///< so far it had confirmed its own when it gave it up
constexpr Tick kCaptured = 40;   ///< so far its datagrams tell that one

TraceStory trace_of(PeerId peer, Tick until, bool superseded, std::uint64_t other_world) {
  TraceStory t;
  t.label = std::to_string(peer);
  t.header.peer = peer;
  t.superseded = superseded;
  for (Tick i = 0; i <= until; ++i) t.confirmed[i] = i < kOut ? 1 : other_world;
  return t;
}

/// A capture of peer 2, which was out without knowing it, and began anew: first the world that it gave up, then the
/// one that it was given.
RebuiltWorlds its_capture() {
  RebuiltWorlds all;
  for (Tick i = 0; i <= kCaptured; ++i) all[i] = {i < kOut ? 1U : 2U, {{2, 0}}};
  for (Tick i = kCaptured + 10; i <= 60; ++i) all[i] = {3, {}};
  return all;
}

// Once the last ticks were taken for a difference: that peer's process had not confirmed them when it began anew.
TEST(WorldCheck, AWorldThatWasGivenUpIsToldFurtherThanItWasConfirmed) {
  const std::vector<WorldCheck> c =
      check_worlds(its_capture(), {trace_of(0, 60, false, 3), trace_of(2, kConfirmed, true, 2)});
  EXPECT_EQ(c[0].given_up, static_cast<std::uint64_t>(kCaptured - kOut + 1));
  EXPECT_EQ(c[0].beyond, 9U);
  EXPECT_EQ(c[0].alike, c[0].compared);
  EXPECT_EQ(c[0].compared, 31U);
  EXPECT_EQ(c[1].alike, static_cast<std::uint64_t>(kConfirmed + 1));
  EXPECT_EQ(c[1].compared, c[1].alike);
}

TEST(WorldCheck, WhatNobodyGaveUpDiffers) {
  const TraceStory stands = trace_of(0, 60, false, 3);
  // Nobody began anew.
  EXPECT_EQ(check_worlds(its_capture(), {stands, trace_of(2, kConfirmed, false, 2)})[0].first_difference, kOut);
  // The world that was given up is another one.
  EXPECT_EQ(check_worlds(its_capture(), {stands, trace_of(2, kConfirmed, true, 4)})[0].first_difference, kOut);
  // In the world that was rebuilt the one who began anew is out, too.
  RebuiltWorlds without = its_capture();
  for (Tick i = kConfirmed + 1; i <= kCaptured; ++i) without[i].given_up.clear();
  EXPECT_EQ(check_worlds(without, {stands, trace_of(2, kConfirmed, true, 2)})[0].first_difference, kConfirmed + 1);
}

}  // namespace
}  // namespace padr::capture
