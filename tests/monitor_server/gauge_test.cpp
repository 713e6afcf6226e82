#include "tools/monitor/gauge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/monitor_server/watched_session.h"
#include "tests/seed.h"
#include "tools/monitor/pieces.h"

namespace padr::monitor {
namespace {

using Points = std::map<std::pair<PeerId, Tick>, trace::InconsistencyPoint>;

/// What the lab's own meter has measured.
Points truth_of(const lab::Simulation& s) {
  Points out;
  for (PeerId p = 0; p < s.peers(); ++p)
    for (const auto& point : s.meter().series(p)) out[{p, point.tick}] = point;
  return out;
}

TEST(Gauge, MeasuresWhatTheTracesMeterMeasures) {
  const std::uint64_t seed = test::seed();
  test::WatchedSession session(3, 900, seed);
  Gauge gauge(static_cast<int>(session.scene.bodies.size()));
  Points measured;
  session.run(
      [&](const Origin& from, const Message& m) {
        if (const auto* f = std::get_if<Frame>(&m)) gauge.frame(from.slot, std::make_shared<Frame>(*f));
        if (const auto* a = std::get_if<Agreed>(&m)) gauge.agreed(std::make_shared<Agreed>(*a));
      },
      [&](Tick) {
        for (const auto& [slot, point] : gauge.take()) measured[{slot, point.tick}] = point;
      });
  const Points truth = truth_of(*session.simulation);
  EXPECT_GT(measured.size(), 3U * 250U);
  double sum = 0;
  std::size_t compared = 0;
  for (const auto& [at, point] : measured) {
    if (!truth.contains(at)) continue;  // the lab's meter waits for the first peer to confirm a tick
    ++compared;
    const auto& t = truth.at(at);
    ASSERT_EQ(point.avatars_m, t.avatars_m) << "peer " << int{at.first} << " tick " << at.second;
    ASSERT_EQ(point.bodies_m, t.bodies_m) << "peer " << int{at.first} << " tick " << at.second;
    ASSERT_EQ(point.shown_m, t.shown_m) << "peer " << int{at.first} << " tick " << at.second;
    sum += double{point.combined()};
  }
  EXPECT_GT(compared, 3U * 250U);
  EXPECT_GT(sum, 10) << "there was something to measure";
}

// As it comes over the wire: to the millimetre, in pieces.
TEST(Gauge, TheWireCostsMillimetres) {
  const std::uint64_t seed = test::seed();
  test::WatchedSession session(3, 600, seed);
  Gauge gauge(static_cast<int>(session.scene.bodies.size()));
  std::map<PeerId, Pieces<Frame>> frames;
  std::map<PeerId, Pieces<Agreed>> agreed;
  Points measured;
  session.run(
      [&](const Origin& from, const Message& m) {
        for (const Bytes& datagram : encode(from, m)) {
          const auto told = decode_told(datagram);
          ASSERT_TRUE(told);
          if (const auto* f = std::get_if<Frame>(&told->message))
            if (auto whole = frames[from.slot].add(*f)) gauge.frame(from.slot, whole);
          if (const auto* a = std::get_if<Agreed>(&told->message))
            if (auto whole = agreed[from.slot].add(*a)) gauge.agreed(whole);
        }
      },
      [&](Tick) {
        for (const auto& [slot, point] : gauge.take()) measured[{slot, point.tick}] = point;
      });
  const Points truth = truth_of(*session.simulation);
  EXPECT_GT(measured.size(), 3U * 150U);
  for (const auto& [at, point] : measured)
    if (truth.contains(at)) {
      EXPECT_NEAR(point.combined(), truth.at(at).combined(), 0.02);
    }
}

std::shared_ptr<Frame> frame(Tick tick, float x) {
  auto f = std::make_shared<Frame>();
  f->tick = tick;
  f->total = 3;  // a body, two avatars
  f->flags = {{true, true, false, 0}, {true, true, false, 0}, {true, true, false, 1}};
  f->live = {{{x, 0}, 0}, {{x, 1}, 0}, {{x, 2}, 0}};
  f->shown = f->live;
  return f;
}

std::shared_ptr<Agreed> agreed(Tick tick, PeerId owner) {
  auto a = std::make_shared<Agreed>();
  a->tick = tick;
  a->total = 3;
  a->flags = {{true, true, false, owner}, {true, true, false, 0}, {true, true, false, 1}};
  a->at = {{{5, 0}, 0}, {{5, 1}, 0}, {{5, 2}, 0}};
  return a;
}

TEST(Gauge, ByHand) {
  Gauge g(1);
  g.frame(0, frame(3, 1));
  g.frame(1, frame(3, 1.5F));
  EXPECT_TRUE(g.take().empty()) << "not confirmed yet";
  g.agreed(agreed(3, 1));
  const auto points = g.take();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].first, 0);
  EXPECT_FLOAT_EQ(points[0].second.bodies_m, 0.5F) << "the body is peer 1's";
  EXPECT_FLOAT_EQ(points[0].second.avatars_m, 0.5F) << "its own avatar is right";
  EXPECT_FLOAT_EQ(points[1].second.bodies_m, 0);
  EXPECT_FLOAT_EQ(points[1].second.avatars_m, 0.5F);
  EXPECT_TRUE(g.take().empty()) << "measured once";
}

TEST(Gauge, WhatNobodyOwnsIsWhereItIsAgreedToBe) {
  Gauge g(1);
  g.frame(0, frame(3, 1));
  g.frame(1, frame(3, 1));
  g.agreed(agreed(3, kNoPeer));
  const auto points = g.take();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_FLOAT_EQ(points[0].second.bodies_m, 4);
}

TEST(Gauge, WhatNobodyOwnsIsComparedBetweenViewsThatPlayItOutAlone) {
  Gauge g(1);
  for (PeerId p = 0; p < 2; ++p) {
    auto f = frame(3, p == 0 ? 1 : 1.5F);
    f->unowned_alone = true;
    g.frame(p, f);
  }
  g.agreed(agreed(3, kNoPeer));
  const auto points = g.take();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_FLOAT_EQ(points[0].second.bodies_m, 0.5F);
  EXPECT_FLOAT_EQ(points[1].second.bodies_m, 0.5F);
}

TEST(Gauge, ATickWithALostFrameIsLeftOut) {
  Gauge g(1);
  g.frame(0, frame(3, 1));
  g.frame(1, frame(3, 1));
  g.frame(0, frame(6, 1));
  g.agreed(agreed(6, 0));
  EXPECT_TRUE(g.take().empty()) << "peer 1's may still come";
  g.frame(1, frame(36, 1));
  EXPECT_TRUE(g.take().empty());
  g.frame(1, frame(6, 1.25F));
  ASSERT_EQ(g.take().size(), 2U) << "late, but there";
  g.frame(0, frame(9, 1));
  g.agreed(agreed(9, 0));
  g.frame(1, frame(42, 1));
  g.frame(0, frame(42, 1));
  EXPECT_TRUE(g.take().empty()) << "lost";
  g.frame(1, frame(9, 1));
  EXPECT_TRUE(g.take().empty()) << "too late now";
}

TEST(Gauge, ATickWhoseAgreedWorldIsLostIsForgotten) {
  Gauge g(1);
  g.frame(0, frame(3, 1));
  g.frame(0, frame(126, 1));
  g.agreed(agreed(123, 0));
  g.take();
  g.agreed(agreed(3, 0));
  EXPECT_EQ(g.take().size(), 1U) << "two seconds late is not too late";
  g.frame(0, frame(6, 1));
  g.agreed(agreed(129, 0));
  g.take();
  g.agreed(agreed(6, 0));
  EXPECT_TRUE(g.take().empty()) << "its frame is not kept any more";
}

TEST(Gauge, WhoHasGoneIsNotWaitedFor) {
  Gauge g(1);
  g.frame(0, frame(3, 1));
  g.frame(1, frame(3, 1));
  g.frame(0, frame(6, 1));
  g.agreed(agreed(6, 0));
  EXPECT_TRUE(g.take().empty());
  g.forget(1);
  EXPECT_EQ(g.take().size(), 1U);
}

}  // namespace
}  // namespace padr::monitor
