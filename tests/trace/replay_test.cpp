#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>

#include "common/model/user_error.h"
#include "common/trace/trace_writer.h"
#include "tests/trace/recorded_run.h"
#include "tools/lab/replay.h"

namespace padr {
namespace {

using test::RecordedRun;
using test::RunConfig;
using Bytes = std::vector<std::byte>;

lab::ReplayResult replay(const Bytes& bytes) {
  trace::TraceReader reader(bytes, "some.trace");
  return lab::replay(reader);
}

TEST(Replay, EveryPeerOfARunDoesTheSameAgain) {
  for (const char* technique : {"full", "adaptive", "avatar-only"}) {
    RunConfig c;
    c.peers = 3;
    c.netem = "delay 60ms 40ms loss 15% duplicate 3% corrupt 1%";
    c.technique = technique_by_name(technique);
    const RecordedRun run(c);
    for (const auto& t : run.traces) {
      const lab::ReplayResult r = replay(t);
      EXPECT_EQ(r.difference, "") << technique;
      EXPECT_EQ(r.ticks, c.ticks);
      EXPECT_GT(r.datagrams_in, 30U);
      EXPECT_GT(r.datagrams_out, 40U);
      EXPECT_GT(r.confirmed, 200U);
      EXPECT_FALSE(r.truncated);
    }
  }
}

TEST(Replay, LeavingIsPartOfIt) {
  RunConfig c;
  c.leave_at = 150;
  const RecordedRun run(c);
  for (const auto& t : run.traces) EXPECT_EQ(replay(t).difference, "");
  EXPECT_EQ(run.nodes[0]->replica().seat(1).presence, node::Presence::kLeft);
}

// Once, what a judge rejected for another reason than a signature was taken in by the replay, and what it did reject
// had set the clock.
TEST(Replay, WhatAJudgeRejectsChangesNothing) {
  for (const auto why : {sync::DropReason::kCutOff, sync::DropReason::kRight, sync::DropReason::kValue}) {
    RunConfig c;
    c.netem = "delay 100ms 80ms";
    int asked = 0;
    c.before_step = [&](Tick t, const auto& nodes) {
      if (t > 1) return;
      nodes[0]->set_judge([&, why](const sync::StatePacket& /*packet*/, PeerId /*by*/) {
        return ++asked % 5 == 0 ? why : sync::DropReason::kNone;
      });
    };
    const RecordedRun run(c);
    EXPECT_GT(asked, 50);
    EXPECT_EQ(replay(run.traces[0]).difference, "") << static_cast<int>(why);
  }
}

TEST(Replay, ATraceThatBreaksOffIsReplayedAsFarAsItGoes) {
  RunConfig c;
  c.ticks = 120;
  const Bytes whole = RecordedRun(c).traces[0];
  for (std::size_t n = whole.size() - 400; n < whole.size(); n += 7) {
    const lab::ReplayResult r = replay({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)});
    EXPECT_EQ(r.difference, "") << n;
    EXPECT_TRUE(r.truncated);
  }
}

/// The trace written anew, each event through `change`, which may alter it or, returning false, leave it out.
struct Tamper {
  std::function<bool(trace::Step&, trace::LiveView&)> step = [](auto&, auto&) { return true; };
  std::function<bool(Micros&, Bytes&)> received = [](auto&, auto&) { return true; };
  std::function<bool(Tick, Bytes&)> sent = [](auto, auto&) { return true; };
  std::function<bool(trace::Confirmed&, trace::Truth&)> confirmed = [](auto&, auto&) { return true; };
  std::function<void(trace::Header&)> header = [](auto&) {};
};

Bytes tampered(const Bytes& bytes, const Tamper& how) {
  trace::TraceReader r(bytes, "some.trace");
  Bytes out;
  trace::Header h = r.header();
  how.header(h);
  trace::TraceWriter w(h, [&out](std::span<const std::byte> b) { out.insert(out.end(), b.begin(), b.end()); });
  while (const auto e = r.next()) {
    if (const auto* s = std::get_if<trace::Step>(&*e)) {
      trace::Step step = *s;
      trace::LiveView live = r.live();
      if (how.step(step, live)) w.step(step, live);
    } else if (const auto* in = std::get_if<trace::Received>(&*e)) {
      Micros at = in->at;
      Bytes datagram(in->datagram.begin(), in->datagram.end());
      if (how.received(at, datagram)) w.received(at, datagram);
    } else if (const auto* sent = std::get_if<trace::Sent>(&*e)) {
      Bytes datagram(sent->datagram.begin(), sent->datagram.end());
      if (how.sent(sent->tick, datagram)) w.sent(sent->to, sent->tick, datagram);
    } else if (const auto* c = std::get_if<trace::Confirmed>(&*e)) {
      trace::Confirmed confirmed = *c;
      trace::Truth truth = r.truth();
      if (how.confirmed(confirmed, truth)) w.confirmed(confirmed.tick, confirmed.hash, truth);
    } else if (const auto* f = std::get_if<trace::Footer>(&*e)) {
      w.footer(*f);
    }
  }
  return out;
}

TEST(Replay, WhateverIsTamperedWithIsCaught) {
  RunConfig c;
  const Bytes whole = RecordedRun(c).traces[0];
  EXPECT_EQ(replay(tampered(whole, {})).difference, "");
  const auto expect = [&](const Tamper& how, const std::string& what) {
    const std::string found = replay(tampered(whole, how)).difference;
    EXPECT_NE(found.find(what), std::string::npos) << "expected '" << what << "', found '" << found << "'";
  };
  Tamper t;
  t.step = [](trace::Step& s, trace::LiveView&) {
    if (s.tick == 100) s.target.x = std::nextafter(s.target.x, 100.0F);
    return true;
  };
  expect(t, "tick 100: live world differs, first in avatar 0");
  t = {};
  t.step = [](trace::Step& s, trace::LiveView&) {
    if (s.tick == 77) s.live_hash ^= 1U;
    return true;
  };
  expect(t, "tick 77: live hash differs");
  t = {};
  t.step = [](trace::Step& s, trace::LiveView& v) {
    if (s.tick == 78) v.shown[3].x += 0.001F;
    return true;
  };
  expect(t, "tick 78: shown positions differ");
  t = {};
  t.confirmed = [](trace::Confirmed& s, trace::Truth&) {
    if (s.tick == 60) s.hash ^= 1U;
    return true;
  };
  expect(t, "confirmed world of tick 60 differs");
  t = {};
  t.confirmed = [](trace::Confirmed& s, trace::Truth& truth) {
    if (s.tick == 61) truth.owner[0] = 1;
    return true;
  };
  expect(t, "confirmed world of tick 61 differs");
  t = {};
  t.sent = [](Tick tick, Bytes& d) {
    if (tick >= 200) d[d.size() / 2] ^= std::byte{1};
    return true;
  };
  expect(t, "has other bytes");
  Bytes damaged = whole;
  damaged[whole.size() / 2] ^= std::byte{1};
  EXPECT_THROW(replay(damaged), UserError) << "it does not count as a difference";
  t = {};
  t.sent = [](Tick tick, Bytes&) { return tick < 200; };
  expect(t, "were recorded");
  t = {};
  int in = 0;
  t.received = [&in](Micros&, Bytes&) { return ++in != 5; };
  expect(t, "tick ");
  t = {};
  t.header = [](trace::Header& h) { h.technique.threshold_low = h.technique.threshold_high = 0.05F; };
  expect(t, "tick ");
}

TEST(Replay, WhatCannotBeReplayedIsSaid) {
  RunConfig c;
  c.ticks = 10;
  const Bytes whole = RecordedRun(c).traces[0];
  const auto error = [&](const std::function<void(trace::Header&)>& change) -> std::string {
    Tamper t;
    t.header = change;
    try {
      replay(tampered(whole, t));
    } catch (const UserError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_NE(error([](auto& h) { ++h.scenario_seed; }).find("another scene"), std::string::npos);
  EXPECT_NE(error([](auto& h) { h.scenario_text = "nonsense"; }).find("some.trace (its scenario arena)"),
            std::string::npos);
  EXPECT_NE(error([](auto& h) { ++h.fingerprint; }).find("physics plays out differently"), std::string::npos);
}

TEST(Replay, OneLineAndAnExitCode) {
  RunConfig c;
  c.ticks = 60;
  const std::string file = testing::TempDir() + "replay_" + std::to_string(getpid()) + ".trace";
  const auto verdict = [&file](const Bytes& bytes) {
    std::ofstream out(file, std::ios::binary);
    for (const std::byte b : bytes) out.put(static_cast<char>(b));
    out.close();
    testing::internal::CaptureStdout();
    const int status = lab::run_replay(file);
    return std::to_string(status) + " " + testing::internal::GetCapturedStdout().substr(file.size());
  };
  const Bytes whole = RecordedRun(c).traces[1];
  EXPECT_EQ(verdict(whole).rfind("0 : identical: peer 1, 60 ticks, ", 0), 0U) << verdict(whole);
  Tamper t;
  t.step = [](trace::Step& s, trace::LiveView&) {
    if (s.tick == 30) s.live_hash ^= 1U;
    return true;
  };
  EXPECT_EQ(verdict(tampered(whole, t)), "1 : DIFFERS at tick 30: live hash differs\n");
  std::remove(file.c_str());
  EXPECT_THROW(lab::run_replay(file), UserError);
}

TEST(RecordedReplica, WithoutARecordingItIsTheSameNode) {
  RunConfig c;
  c.record = false;
  const RecordedRun silent(c);
  c.record = true;
  const RecordedRun recorded(c);
  EXPECT_TRUE(silent.traces[0].empty());
  EXPECT_EQ(silent.nodes[0]->replica().live_hash(), recorded.nodes[0]->replica().live_hash());
}

}  // namespace
}  // namespace padr
