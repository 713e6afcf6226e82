#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "tests/lab/session.h"
#include "tests/seed.h"
#include "tools/lab/rates.h"

namespace padr {
namespace {

int minutes() {
  const char* text = std::getenv("PADR_TEST_MINUTES");
  return text == nullptr ? 6 : std::clamp(std::atoi(text), 6, 24 * 60);
}

/// What one virtual minute took, over all peers.
struct Minute {
  std::size_t log_ticks = 0;  ///< the most that any peer kept at any tick, as the next two
  std::size_t own_updates = 0;
  std::size_t pending_checks = 0;
  double updates = 0;
  double replayed = 0;  ///< steps
};

class Meter {
 public:
  explicit Meter(const lab::Simulation& s) : s_(s) {}

  void see(Tick t) {
    for (PeerId p = 0; p < s_.peers(); ++p) {
      const node::Replica::Kept kept = s_.replica(p).kept();
      now_.log_ticks = std::max(now_.log_ticks, kept.log_ticks);
      now_.own_updates = std::max(now_.own_updates, kept.own_updates);
      now_.pending_checks = std::max(now_.pending_checks, kept.pending_checks);
    }
    if (t % (60 * kTicksPerSecond) == 0) end_minute();
  }

  std::vector<Minute> minutes;

 private:
  void end_minute() {
    double updates = 0;
    double replayed = 0;
    for (PeerId p = 0; p < s_.peers(); ++p) {
      updates += static_cast<double>(s_.replica(p).stats().bundles);
      replayed += static_cast<double>(s_.replica(p).agreed().replayed_steps());
    }
    now_.updates = updates - updates_;
    now_.replayed = replayed - replayed_;
    updates_ = updates;
    replayed_ = replayed;
    minutes.push_back(now_);
    now_ = {};
  }

  const lab::Simulation& s_;
  Minute now_;
  double updates_ = 0;
  double replayed_ = 0;
};

/// Of the minutes from..to-1: the most of what is kept, the mean of what is done.
Minute over(const std::vector<Minute>& all, std::size_t from, std::size_t to) {
  Minute m;
  const auto n = static_cast<double>(to - from);
  for (std::size_t i = from; i < to; ++i) {
    m.log_ticks = std::max(m.log_ticks, all[i].log_ticks);
    m.own_updates = std::max(m.own_updates, all[i].own_updates);
    m.pending_checks = std::max(m.pending_checks, all[i].pending_checks);
    m.updates += all[i].updates / n;
    m.replayed += all[i].replayed / n;
  }
  return m;
}

void show(const char* name, const Minute& m) {
  std::printf(
      "%s: kept at most %zu ticks of updates, %zu own ones, %zu checks; %.0f updates, %.0f replayed steps a minute\n",
      name, m.log_ticks, m.own_updates, m.pending_checks, m.updates, m.replayed);
}

// The last minutes of a long session against its first ones, after one of warming up.
TEST(Flatness, WhatAPeerKeepsAndDoesDoesNotGrow) {
  const int all = minutes();
  test::Session session("arena", 4, technique_by_name("full"), "delay 60ms 20ms loss 2%", test::seed(3), all * 60);
  Meter meter(*session.simulation);
  session.simulation->run([&meter](Tick t) { meter.see(t); });
  ASSERT_EQ(session.simulation->confirmed_mismatches(), 0U);
  const std::size_t n = meter.minutes.size();
  const std::size_t part = std::max<std::size_t>(2, n / 6);
  const Minute first = over(meter.minutes, 1, 1 + part);
  const Minute last = over(meter.minutes, n - part, n);
  show("first", first);
  show("last", last);
  // Losses cluster now and then: the most of a few minutes is no steady figure. A leak would be a multiple.
  EXPECT_LE(last.log_ticks, 2 * first.log_ticks);
  EXPECT_LE(last.own_updates, 2 * first.own_updates);
  EXPECT_LE(last.pending_checks, first.pending_checks + 4);
  EXPECT_GT(first.updates, 100);
  EXPECT_LE(last.updates, 1.3 * first.updates);
  EXPECT_LE(last.replayed, 1.3 * first.replayed);
}

}  // namespace
}  // namespace padr
