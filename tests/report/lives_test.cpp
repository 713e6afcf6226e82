// The report of a session that people join late, vanish from and come back to.
#include <gtest/gtest.h>

#include "common/model/user_error.h"
#include "tests/seed.h"
#include "tests/trace/recorded_lives.h"
#include "tools/report/analysis.h"
#include "tools/report/outputs.h"

namespace padr {
namespace {

using report::TraceBytes;

const test::RecordedLives& session() {
  static const test::RecordedLives run(test::seed());
  return run;
}

std::vector<TraceBytes> traces_of(const std::vector<test::RecordedLives::Key>& keys) {
  std::vector<TraceBytes> out;
  for (const auto& k : keys) out.push_back({session().label(k), session().traces.at(k)});
  return out;
}

std::vector<TraceBytes> all_traces() {
  std::vector<TraceBytes> out;
  for (const auto& [key, bytes] : session().traces) out.push_back({session().label(key), bytes});
  return out;
}

const report::Peer& of(const report::Report& r, const std::string& label) {
  for (const report::Peer& p : r.peers)
    if (p.label == label) return p;
  throw UserError("no " + label);
}

TEST(ReportOfLives, EveryLifeIsMeasuredWhileItLasts) {
  const report::Report r = report::analyse(all_traces());
  ASSERT_EQ(r.peers.size(), 6U);
  EXPECT_EQ(r.peers_at_start(), 3);
  EXPECT_EQ(r.confirmed.mismatches, 0U) << r.confirmed.who;
  EXPECT_GT(r.confirmed.ticks, 800U);
  for (const report::Peer& p : r.peers) {
    SCOPED_TRACE(p.label);
    ASSERT_FALSE(p.series.empty());
    EXPECT_GE(p.series.front().tick, p.came);
    EXPECT_LE(p.series.back().tick, p.went());
    EXPECT_GT(p.series.size(), 60U);
    EXPECT_GT(p.traffic.datagrams, 20U);
  }
  EXPECT_EQ(of(r, "person0.trace").came, 0);
  EXPECT_GE(of(r, "person0.trace").left_at, 0);
  EXPECT_GT(of(r, "person3.trace").came, 100);
  EXPECT_FALSE(of(r, "person1.trace").clean) << "killed";
  EXPECT_TRUE(of(r, "person2.trace").superseded);
  EXPECT_GT(of(r, "person2.2.trace").came, of(r, "person2.trace").last_tick - 2);
  EXPECT_GT(r.confirmed.given_up, 0U);
}

TEST(ReportOfLives, TheTableSaysWhoCameAndWentWhen) {
  const std::string table = report::table(report::analyse(all_traces()));
  for (const char* expected : {"3 peers at the start, 3 traces of who came later", "Who came and went.", "broke off",
                               "began anew", "left", "person2.2.trace", "in lives given up later"})
    EXPECT_NE(table.find(expected), std::string::npos) << expected << " in\n" << table;
}

TEST(ReportOfLives, TwoInOneSlotHaveLinksOfTheirOwn) {
  const report::Report r = report::analyse(all_traces());
  std::map<std::pair<std::string, std::string>, int> seen;
  for (const report::Link& l : r.links) {
    EXPECT_EQ(++seen[std::pair(l.from_name, l.to_name)], 1);
    EXPECT_LE(l.received, l.sent + 1) << l.from_name << " to " << l.to_name;
    EXPECT_LT(l.delay_mean_ms, 100) << l.from_name << " to " << l.to_name;
  }
  EXPECT_GT(seen.size(), 12U);
}

TEST(ReportOfLives, ALateOneAloneIsEnough) {
  const report::Report r = report::analyse(traces_of({{3, 0}}));
  EXPECT_GT(r.peers.at(0).series.size(), 300U);
  EXPECT_NE(report::table(r).find("no trace of peer"), std::string::npos);
}

TEST(ReportOfLives, TheSameLifeTwiceIsRefused) {
  try {
    report::analyse(traces_of({{3, 0}, {0, 0}, {3, 0}}));
    FAIL();
  } catch (const UserError& e) {
    EXPECT_NE(std::string(e.what()).find("person3.trace: is a trace of peer"), std::string::npos) << e.what();
  }
}

TEST(ReportOfLives, AllOutputsAreMade) {
  const report::Report r = report::analyse(all_traces());
  EXPECT_NE(report::json(r, {}).find("\"came_tick\""), std::string::npos);
  EXPECT_EQ(report::csv_files(r).size(), 4U);
  EXPECT_GE(report::plot_files(r).size(), 3U);
}

}  // namespace
}  // namespace padr
