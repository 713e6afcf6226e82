// The report of a session that people join late, vanish from and come back to.
#include <gtest/gtest.h>

#include "common/model/user_error.h"
#include "shell/netem_text.h"
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
  EXPECT_EQ(of(r, "person0.trace").came, of(r, "person1.trace").came) << "the begin of play";
  EXPECT_GE(of(r, "person0.trace").left_at, 0);
  EXPECT_GT(of(r, "person3.trace").came, 100);
  EXPECT_FALSE(of(r, "person1.trace").clean) << "killed";
  EXPECT_TRUE(of(r, "person2.trace").superseded);
  EXPECT_GT(of(r, "person2.2.trace").came, of(r, "person2.trace").last_tick - 2);
  EXPECT_GT(r.confirmed.given_up, 0U);
}

// Once, a session of four was called one of three, as play had waited for three.
TEST(ReportOfLives, MoreMayBeThereAtTheStartThanPlayWaitedFor) {
  report::Report r;
  for (int p = 0; p < 5; ++p) {
    r.peers.emplace_back().header.wanted = 3;
    r.peers.back().header.incarnation = p == 0 ? 0 : 40U + static_cast<std::uint32_t>(p);
    r.peers.back().came = p == 4 ? 1000 : 60;
  }
  EXPECT_EQ(r.peers_at_start(), 4);
  r.peers[3].header.spectates = true;
  EXPECT_EQ(r.peers_at_start(), 3);
}

TEST(ReportOfLives, TheTableSaysWhoCameAndWentWhen) {
  const std::string table = report::table(report::analyse(all_traces()));
  for (const char* expected : {"3 peers at the start, 3 traces of who came later", "Who came and went.", "broke off",
                               "began anew", "left", "person2.2.trace", "that were declared gone later"})
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

// A peer that was held up goes on in another incarnation of the same slot. Datagrams to and from the incarnation before
// have numbers of their own, and some of them arrive when the next one has begun.
TEST(ReportOfLives, LinksOfAPeerThatCameBackAreInOrder) {
  std::map<std::pair<int, int>, std::vector<std::byte>> recorded;
  lab::VirtualNetworkConfig c;
  c.scene = scenarios::load_embedded("arena", 1);
  c.technique = technique_by_name("full");
  c.netem = shell::parse_netem("delay 150ms");
  c.seed = test::seed();
  c.slots = 3;
  c.wanted = 3;
  c.recording = [&recorded](int person, int incarnation) -> std::optional<node::RecordedReplica::Recording> {
    trace::Provenance from;
    from.scenario = "arena";
    from.scenario_text = std::string(scenarios::embedded_text("arena"));
    from.scenario_seed = 1;
    from.start_unix_us = 1 + person;
    std::vector<std::byte>& into = recorded[{person, incarnation}];
    return node::RecordedReplica::Recording{
        from, [&into](std::span<const std::byte> b) { into.insert(into.end(), b.begin(), b.end()); }};
  };
  lab::VirtualNetwork g(c);
  const auto run = [&g](double s) { g.run_to(g.now() + static_cast<Micros>(s * 1e6)); };
  g.start({});
  g.start(0);
  g.start(0);
  run(5);
  g.pause(2, true);
  run(5);
  g.pause(2, false);
  run(6);
  g.finish();
  std::vector<TraceBytes> traces;
  for (const auto& [key, bytes] : recorded)
    traces.push_back({std::to_string(key.first) + "." + std::to_string(key.second), bytes});
  ASSERT_GE(traces.size(), 4U) << "it came back";
  const report::Report r = report::analyse(traces);
  EXPECT_GE(r.links.size(), 8U);
  for (const report::Link& l : r.links)
    EXPECT_EQ(l.reordered, 0U) << l.from_name << " to " << l.to_name << ", of " << l.received << " received";
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
  EXPECT_EQ(report::csv_files(r).size(), 5U);
  EXPECT_GE(report::plot_files(r).size(), 3U);
}

}  // namespace
}  // namespace padr
