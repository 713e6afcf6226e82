#include "tools/report/analysis.h"
#include "shell/input_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>

#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "common/trace/trace_reader.h"
#include "common/trace/trace_writer.h"
#include "shell/netem_text.h"
#include "tests/seed.h"
#include "tests/trace/recorded_run.h"
#include "tools/report/outputs.h"

namespace padr {
namespace {

using Bytes = std::vector<std::byte>;
using report::TraceBytes;

std::vector<TraceBytes> labelled(const std::vector<Bytes>& traces) {
  std::vector<TraceBytes> out;
  for (std::size_t p = 0; p < traces.size(); ++p) out.push_back({"peer" + std::to_string(p) + ".trace", traces[p]});
  return out;
}

void expect_same(const trace::Inconsistency& a, const trace::Inconsistency& b) {
  EXPECT_EQ(a.ticks, b.ticks);
  EXPECT_EQ(a.mean_m, b.mean_m);
  EXPECT_EQ(a.avatar_mean_m, b.avatar_mean_m);
  EXPECT_EQ(a.body_mean_m, b.body_mean_m);
  EXPECT_EQ(a.p95_m, b.p95_m);
  EXPECT_EQ(a.p99_m, b.p99_m);
  EXPECT_EQ(a.peak_m, b.peak_m);
  EXPECT_EQ(a.area_ms, b.area_ms);
  EXPECT_EQ(a.final_m, b.final_m);
  EXPECT_EQ(a.shown_mean_m, b.shown_mean_m);
  EXPECT_EQ(a.shown_peak_m, b.shown_peak_m);
}

void expect_same_deeds(const report::Peer& r, PeerId p, const trace::FidelityMeter& lab) {
  const trace::FidelitySeries& series = lab.series(p);
  ASSERT_EQ(r.fidelity_series.size(), series.size());
  for (std::size_t i = 0; i < series.size(); ++i) {
    ASSERT_EQ(r.fidelity_series[i].tick, series[i].tick);
    ASSERT_EQ(r.fidelity_series[i].own_m, series[i].own_m) << "tick " << series[i].tick;
    ASSERT_EQ(r.fidelity_series[i].others_m, series[i].others_m) << "tick " << series[i].tick;
    ASSERT_EQ(r.fidelity_series[i].nobody_m, series[i].nobody_m) << "tick " << series[i].tick;
    ASSERT_EQ(r.pcc_series[i].cost_m, lab.pcc().series(p)[i].cost_m) << "tick " << series[i].tick;
  }
  EXPECT_EQ(r.deeds, lab.deeds(p));
  EXPECT_EQ(r.pcc.bodies_peak, lab.pcc().result(p).bodies_peak);
}

/// The lab's simulation, recorded.
struct RecordedSimulation {
  Scene scene = scenarios::load_embedded("arena", 3);
  std::vector<Bytes> traces{4};
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::unique_ptr<lab::Simulation> simulation;

  explicit RecordedSimulation(const Technique& technique, const std::string& netem) {
    lab::SimulationConfig c;
    c.scene = scene;
    c.peers = 4;
    c.technique = technique;
    c.netem = shell::parse_netem(netem);
    c.ticks = 600;
    c.fidelity = true;
    trace::Provenance from;
    from.scenario = "arena";
    from.scenario_text = std::string(scenarios::embedded_text("arena"));
    from.scenario_seed = 3;
    for (std::size_t p = 0; p < 4; ++p) {
      inputs.push_back(shell::make_input("wander", {scene, static_cast<int>(p), 9, {}}));
      c.inputs.push_back(inputs.back().get());
      c.recordings.push_back(node::RecordedReplica::Recording{
          from, [this, p](std::span<const std::byte> b) { traces[p].insert(traces[p].end(), b.begin(), b.end()); }});
    }
    simulation = std::make_unique<lab::Simulation>(std::move(c));
    simulation->run();
    simulation->finish();
  }
};

// Stops are looked at until half a second afterwards, and a trace ends with its last step.
void expect_same_motion(const trace::ShownMotion& a, const trace::ShownMotion& b) {
  EXPECT_EQ(a.ticks, b.ticks);
  EXPECT_EQ(a.stride_change_m, b.stride_change_m);
  EXPECT_EQ(a.unexplained_m, b.unexplained_m);
  EXPECT_EQ(a.stops, b.stops);
  EXPECT_EQ(a.overshoot_m, b.overshoot_m);
  EXPECT_EQ(a.overlap_m, b.overlap_m);
  EXPECT_EQ(a.overlap_made_m, b.overlap_made_m);
  EXPECT_EQ(a.freezes, b.freezes);
  EXPECT_GT(a.stride_change_m, 0);
}

// The report, which sees traces only, and the lab, which sees the nodes, measure the same.
TEST(Report, EqualsTheLabsOwnMeter) {
  for (const char* technique : {"full", "fixed", "avatar-only"}) {
    SCOPED_TRACE(technique);
    const RecordedSimulation run(technique_by_name(technique), "delay 80ms 30ms loss 10% duplicate 2%");
    const lab::Simulation& lab = *run.simulation;
    const report::Report r = report::analyse(labelled(run.traces));
    ASSERT_EQ(r.peers.size(), 4U);
    std::vector<trace::InconsistencySeries> all;
    const auto confirmed = [&lab](PeerId p) { return lab.replica(p).agreed().confirmed().tick; };
    const Tick first = std::max({confirmed(0), confirmed(1), confirmed(2), confirmed(3)});
    for (PeerId p = 0; p < 4; ++p) {
      // The lab goes by what peer 0 has confirmed, the report by whoever was first.
      trace::InconsistencySeries series = r.peers[p].series;
      const trace::InconsistencySeries& of_lab = lab.meter().series(p);
      ASSERT_EQ(series.size(), of_lab.size() + static_cast<std::size_t>(first - confirmed(0)));
      series.resize(of_lab.size());
      expect_same(trace::summarize(series), lab.meter().result(p));
      all.push_back(std::move(series));
      expect_same_deeds(r.peers[p], p, *lab.fidelity());
      const node::ReplicaStats& stats = lab.replica(p).stats();
      EXPECT_EQ(r.peers[p].traffic.updates, stats.updates_by_cause);
      EXPECT_EQ(r.peers[p].traffic.datagrams, stats.datagrams_sent);
      EXPECT_EQ(r.peers[p].traffic.wire_bytes, stats.wire_bytes_sent);
      EXPECT_EQ(r.peers[p].traffic.repeats, stats.repeats);
      EXPECT_EQ(r.peers[p].replayed_steps, lab.replica(p).agreed().replayed_steps());
      expect_same_motion(r.peers[p].shown, lab.shown(p));
    }
    expect_same(trace::summarize_all(all), lab.meter().overall());
    EXPECT_GT(r.overall.inconsistency.mean_m, 0.1);
    EXPECT_EQ(r.overall.fidelity.mean_m, lab.fidelity()->overall().mean_m);
    EXPECT_GT(r.overall.fidelity.mean_m, 0.001);
    EXPECT_EQ(r.left_out, lab.fidelity()->left_out());
    EXPECT_EQ(r.confirmed.ticks, lab.confirmed_ticks());
    // It may know some more confirmed ticks than the lab at the end, not fewer.
    EXPECT_GE(r.hand_overs.takeovers, lab.flips().all().takeovers);
    EXPECT_LE(r.hand_overs.takeovers, lab.flips().all().takeovers + 2);
    EXPECT_EQ(r.confirmed.mismatches, 0U);
  }
}

TEST(Report, BytesAreDividedWithoutRest) {
  const RecordedSimulation run(technique_by_name("full"), "delay 50ms loss 20%");
  for (const report::Peer& p : report::analyse(labelled(run.traces)).peers) {
    double sum = p.traffic.bytes_repeats + p.traffic.bytes_rest();
    for (const double b : p.traffic.bytes_by_cause) sum += b;
    EXPECT_NEAR(sum, static_cast<double>(p.traffic.wire_bytes), 1);
    // Every datagram has at least IP, UDP, our header and tag: 38 bytes that belong to no update.
    EXPECT_GT(p.traffic.bytes_rest(), 38.0 * static_cast<double>(p.traffic.datagrams));
    report::Traffic seconds;
    for (const report::Traffic& t : p.per_second) seconds += t;
    EXPECT_EQ(seconds.wire_bytes, p.traffic.wire_bytes);
    EXPECT_EQ(seconds.updates, p.traffic.updates);
  }
}

TEST(Report, WhoWasInterferedWithIsNoted) {
  test::RunConfig c;
  c.ticks = 60;
  c.before_step = [](Tick t, const auto& nodes) {
    if (t == 20 || t == 30) nodes[1]->retune(technique_by_name("adaptive"));
    if (t == 25) nodes[1]->push(3, {1, 0});
    if (t == 26) nodes[1]->remark({"netem", kNoPeer, "delay 1ms"});
  };
  const test::RecordedRun run(c);
  report::Report r = report::analyse(labelled(run.traces));
  const std::string what = "peer 1 was interfered with while it played: knobs turned 2 times, bodies pushed 1,";
  const auto says = [](const std::string& start) {
    return [start](const std::string& note) { return note.rfind(start, 0) == 0; };
  };
  EXPECT_EQ(std::count_if(r.notes.begin(), r.notes.end(), says(what)), 1);
  EXPECT_EQ(std::count_if(r.notes.begin(), r.notes.end(), says("peer 0 was")), 0);
  const std::string table = report::table(r);
  EXPECT_NE(table.find("Network at the beginning: delay 100ms 50ms loss 10%\n"
                       "Network of peer 1, changed while it played, at last: delay 1ms\n"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("Technique at the beginning: full "), std::string::npos) << table;
  EXPECT_NE(table.find("Technique of peer 1, changed while it played, at last: adaptive "), std::string::npos) << table;
  r.peers[0].header.netem = "loss 1%";
  EXPECT_NE(report::table(r).find("Network of peer 0 at the beginning: loss 1%\n"), std::string::npos);
  EXPECT_TRUE(r.is_seen(r.peers[0]));
  r.peers[0].header.spectates = true;
  EXPECT_FALSE(r.is_seen(r.peers[0])) << "it has no avatar";
  EXPECT_NE(report::table(r).find("2 peers, 1 trace of who only watched, "), std::string::npos);
}

// Once, the network was said to be named as it was at the beginning, too, while the heading has both.
TEST(Report, ANoteSaysOfWhenTheSettingsAreThatTheReportNames) {
  test::RunConfig c;
  c.ticks = 60;
  c.before_step = [](Tick t, const auto& nodes) {
    if (t == 20) nodes[0]->retune(technique_by_name("adaptive"));
    if (t == 26) nodes[1]->remark({"netem", kNoPeer, "delay 1ms"});
  };
  const test::RecordedRun run(c);
  const report::Report r = report::analyse(labelled(run.traces));
  const auto note = [&r](const std::string& start) {
    const auto found =
        std::find_if(r.notes.begin(), r.notes.end(), [&](const auto& n) { return n.rfind(start, 0) == 0; });
    return found == r.notes.end() ? "" : *found;
  };
  EXPECT_EQ(
      note("peer 0"),
      "peer 0 was interfered with while it played: knobs turned 1 time, bodies pushed 0, links impaired or cut or the "
      "peer paused 0; the report names technique and network as they were at the beginning, and what was changed as it "
      "was at last; the figures by technique go by the one at the beginning");
  EXPECT_EQ(
      note("peer 1"),
      "peer 1 was interfered with while it played: knobs turned 0 times, bodies pushed 0, links impaired or cut or "
      "the peer paused 1; the report names technique and network as they were at the beginning, and what was changed "
      "as "
      "it was at last");
}

TEST(Report, WhoCarriedForALinkAndForHowLong) {
  test::RunConfig c;
  c.ticks = 60;
  c.before_step = [](Tick t, const auto& nodes) {
    if (t == 20) nodes[1]->remark({"way", 0, "by 2"});
    if (t == 30) nodes[1]->remark({"way", 0, "by 3"});
    if (t == 40) nodes[1]->remark({"way", 0, "direct"});
    if (t == 50) nodes[0]->remark({"way", 1, "by 2"});
    if (t == 55) nodes[0]->remark({"way", 1, "by nobody"});
  };
  const test::RecordedRun run(c);
  const report::Report r = report::analyse(labelled(run.traces));
  ASSERT_EQ(r.peers[1].carried.size(), 2U);
  const auto [first, second] = std::pair(r.peers[1].carried[0], r.peers[1].carried[1]);
  EXPECT_EQ((std::array{first.to, first.by, second.to, second.by}), (std::array<PeerId, 4>{0, 2, 0, 3}));
  EXPECT_EQ(first.until - first.from, 10);
  EXPECT_EQ(second.from, first.until);
  EXPECT_EQ(second.until - second.from, 10);
  ASSERT_EQ(r.peers[0].carried.size(), 1U);
  EXPECT_EQ(r.peers[0].carried[0].until - r.peers[0].carried[0].from, 5);
  EXPECT_EQ(r.peers[1].remarks, 0U);
  EXPECT_NE(report::table(r).find("who carried"), std::string::npos) << report::table(r);
  EXPECT_NE(report::json(r, {}).find("\"by\": 3"), std::string::npos);
}

TEST(Report, WhatIsDroppedOfWhomAndWhoIsCutOffIsToldAndIsNoInterference) {
  test::RunConfig c;
  c.ticks = 60;
  c.before_step = [](Tick t, const auto& nodes) {
    if (t >= 20 && t < 25) nodes[1]->count_drop(0, sync::DropReason::kValue);
    if (t == 25) nodes[1]->count_drop(0, sync::DropReason::kDuplicate);
    if (t == 26) nodes[1]->cut_off(0, "keeps sending what makes no sense");
  };
  const test::RecordedRun run(c);
  const report::Report r = report::analyse(labelled(run.traces));
  EXPECT_TRUE(r.peers[0].drops.empty());
  ASSERT_EQ(r.peers[1].drops.size(), 1U);
  const report::Drops& d = r.peers[1].drops[0];
  EXPECT_EQ(d.of, 0);
  EXPECT_EQ(d.cut_offs, 1U);
  EXPECT_EQ(d.by_reason.at(static_cast<std::size_t>(sync::DropReason::kValue)), 5U);
  EXPECT_EQ(r.peers[1].dropped.at(static_cast<std::size_t>(sync::DropReason::kValue)), 5U);
  EXPECT_EQ(r.peers[1].remarks, 0U);
  EXPECT_NE(report::table(r).find("5 value"), std::string::npos) << report::table(r);
  EXPECT_NE(report::json(r, {}).find("\"cut_off\": 1"), std::string::npos);
}

TEST(Report, LinksShowWhatTheShimDid) {
  test::RunConfig c;
  c.netem = "delay 100ms";
  const test::RecordedRun clean(c);
  for (const report::Link& l : report::analyse(labelled(clean.traces)).links) {
    EXPECT_EQ(l.lost, 0U);
    EXPECT_EQ(l.duplicates, 0U);
    EXPECT_EQ(l.reordered, 0U);
    EXPECT_GT(l.judged, 20U);
    EXPECT_NEAR(l.delay_p50_ms, 100, 0.01);
    EXPECT_NEAR(l.jitter_ms, 0, 0.01);
  }
  c.netem = "delay 100ms 50ms loss 20% duplicate 10%";
  c.ticks = 1800;
  const test::RecordedRun bad(c);
  for (const report::Link& l : report::analyse(labelled(bad.traces)).links) {
    EXPECT_NEAR(l.loss_percent(), 18, 6) << "a duplicate makes up for a loss";
    EXPECT_GT(l.duplicates, l.received / 20);
    EXPECT_GT(l.reordered, 0U);
    EXPECT_NEAR(l.delay_mean_ms, 100 + 8.3, 5) << "the lab delivers on ticks: half a tick later on average";
    EXPECT_NEAR(l.jitter_ms, 33, 6) << "two uniform draws from +-50 ms differ by 33 ms on average";
  }
}

TEST(Report, DifferingConfirmedWorldsAreNamed) {
  test::RunConfig c;
  c.peers = 3;
  c.ticks = 120;
  std::vector<Bytes> traces = test::RecordedRun(c).traces;
  trace::TraceReader r(traces[1], "t");
  Bytes changed;
  trace::TraceWriter w(r.header(),
                       [&](std::span<const std::byte> b) { changed.insert(changed.end(), b.begin(), b.end()); });
  while (const auto e = r.next()) {
    if (const auto* s = std::get_if<trace::Step>(&*e)) w.step(*s, r.live());
    if (const auto* k = std::get_if<trace::Confirmed>(&*e))
      w.confirmed(k->tick, k->hash + (k->tick >= 60 ? 1 : 0), r.truth());
  }
  traces[1] = changed;
  const report::Report report = report::analyse(labelled(traces));
  EXPECT_EQ(report.confirmed.first_mismatch, 60);
  EXPECT_GT(report.confirmed.mismatches, 20U);
  EXPECT_EQ(report.confirmed.who, "peers 0 2 against peer 1");
  EXPECT_NE(report::table(report).find("CONFIRMED WORLDS DIFFER"), std::string::npos);
}

TEST(Report, AMissingPeerAndABrokenOffTraceAreNoted) {
  test::RunConfig c;
  c.peers = 3;
  const std::vector<Bytes> traces = test::RecordedRun(c).traces;
  std::vector<TraceBytes> given{{"a", traces[0]}, {"c", traces[2]}};
  given[1].bytes.resize(given[1].bytes.size() / 2);
  const report::Report r = report::analyse(given);
  ASSERT_EQ(r.peers.size(), 2U);
  EXPECT_EQ(r.peers[1].header.peer, 2);
  EXPECT_FALSE(r.peers[1].clean);
  const std::string table = report::table(r);
  EXPECT_NE(table.find("no trace of peer 1"), std::string::npos);
  EXPECT_NE(table.find("c breaks off at tick"), std::string::npos);
  EXPECT_GT(r.peers[0].inconsistency.ticks, r.peers[1].inconsistency.ticks) << "the rest goes on without it";
  EXPECT_EQ(r.confirmed.mismatches, 0U);
}

TEST(Report, MissingPeersAndWhatFollowsTheEndAreNoted) {
  test::RunConfig c;
  c.peers = 3;
  std::vector<TraceBytes> given{{"a", test::RecordedRun(c).traces[0]}};
  EXPECT_EQ(report::table(report::analyse(given)).find("no part of a trace"), std::string::npos);
  given[0].bytes.resize(given[0].bytes.size() + 3, std::byte{0x50});
  const std::string table = report::table(report::analyse(given));
  EXPECT_NE(table.find("no trace of peers 1, 2: their entities are measured against"), std::string::npos);
  EXPECT_NE(table.find("a has something behind its end that is no part of a trace"), std::string::npos);
}

TEST(Report, APeerIsMeasuredUntilItsGoodbye) {
  test::RunConfig c;
  c.leave_at = 200;
  c.ticks = 400;
  const report::Report r = report::analyse(labelled(test::RecordedRun(c).traces));
  EXPECT_EQ(r.peers[1].left_at, 200);
  EXPECT_EQ(r.peers[1].last_tick, 400);
  EXPECT_EQ(r.peers[1].series.back().tick, 199) << "the tick before; at the goodbye its avatar is gone";
  EXPECT_GT(r.peers[0].series.back().tick, 300);
  EXPECT_DOUBLE_EQ(r.peers[1].seconds(), 200.0 / 60);
  EXPECT_EQ(r.peers[1].traffic.updates[static_cast<std::size_t>(sync::Cause::kLeave)], 1U);
  EXPECT_EQ(r.peers[1].per_second.size(), 4U) << "nothing after the fourth second";
}

// Damage inside a trace is refused in one line or measured as it is, never worse.
TEST(Report, DamagedTracesAreSurvived) {
  test::RunConfig c;
  c.ticks = 60;
  const std::vector<Bytes> traces = test::RecordedRun(c).traces;
  Rng rng(test::seed());
  int refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<TraceBytes> given = labelled(traces);
    Bytes& b = given[1].bytes;
    // Past the header's text, which is most of a short trace.
    for (std::uint32_t n = 1 + rng.below(3); n > 0; --n)
      b[2000 + rng.below(static_cast<std::uint32_t>(b.size() - 2000))] = static_cast<std::byte>(rng.below(256));
    try {
      const report::Report r = report::analyse(given);
      report::table(r);
      report::json(r, {});
      report::csv_files(r);
      report::plot_files(r);
    } catch (const UserError& e) {
      ++refused;
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(refused, 20);
}

TEST(Report, PeersOfDifferentTechniquesAreGrouped) {
  test::RunConfig c;
  c.peers = 3;
  c.second_technique = technique_by_name("adaptive");
  const report::Report r = report::analyse(labelled(test::RecordedRun(c).traces));
  ASSERT_EQ(r.groups.size(), 2U);
  EXPECT_EQ(r.groups[0].peers.size() + r.groups[1].peers.size(), 3U);
  EXPECT_NE(report::table(r).find("technique B"), std::string::npos);
}

TEST(Report, AuthorityChangesFollowTheConfirmedWorld) {
  const RecordedSimulation run(technique_by_name("full"), "delay 50ms");
  const report::Report r = report::analyse(labelled(run.traces));
  EXPECT_GT(r.authority.size(), 5U);
  std::map<EntityId, PeerId> owners;
  Tick last = 0;
  std::uint64_t takeovers = 0;
  for (const report::AuthorityChange& a : r.authority) {
    EXPECT_GE(a.tick, last);
    last = a.tick;
    const auto before = owners.find(a.body);
    EXPECT_NE(before == owners.end() ? kNoPeer : before->second, a.owner);
    if (before != owners.end() && before->second != kNoPeer && a.owner != kNoPeer) ++takeovers;
    owners[a.body] = a.owner;
  }
  EXPECT_EQ(r.hand_overs.takeovers, takeovers);
  EXPECT_GT(takeovers, 0U);
  EXPECT_NE(report::table(r).find(std::to_string(takeovers) + " times"), std::string::npos);
  EXPECT_NE(report::json(r, {}).find("\"takeovers\": " + std::to_string(takeovers)), std::string::npos);
}

}  // namespace
}  // namespace padr
