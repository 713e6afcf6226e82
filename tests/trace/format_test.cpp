#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "common/trace/trace_format.h"
#include "common/trace/trace_reader.h"
#include "common/trace/trace_writer.h"
#include "tests/seed.h"

namespace padr {
namespace {

using Bytes = std::vector<std::byte>;

trace::Header small_header() {
  trace::Header h;
  h.program = "padr-test";
  h.revision = "abc";
  h.command = {"padr-test", "--name", "J\xFCrgen"};  // Latin 1: command lines need not be UTF-8
  h.scenario = "two";
  h.scenario_text = "text";
  h.scenario_seed = 0xFFFFFFFFFFFFFFFFULL;
  h.netem = "delay 1ms";
  h.netem_seed = 7;
  h.input = "wander";
  h.start_unix_us = 1'700'000'000'000'000;
  h.peer = 1;
  h.peers = 2;
  h.slots = 3;
  h.session = 0xBEEF;
  h.session_id = {1, 2, 3, 0, 0xFF};
  h.scene_hash = 11;
  h.fingerprint = 12;
  h.bodies = 2;
  h.technique = technique_by_name("adaptive");
  h.technique.radius = 1.5F;
  h.technique.steps = 17;
  return h;
}

trace::LiveView view_at(float x) {
  trace::LiveView v;
  for (int e = 0; e < 5; ++e) {
    BodyState s;
    s.position = {x + static_cast<float>(e), -0.0F};
    s.velocity = {e == 3 ? x : 0, std::numeric_limits<float>::denorm_min()};
    s.spin = 0.1F;
    s.awake = e != 2;
    v.states.push_back(s);
    v.shown.push_back(e == 4 ? Vec2{x, 9} : s.position);
  }
  return v;
}

trace::Truth truth_at(float x, PeerId owner) {
  return {{owner, kNoPeer, 0, 1, 2}, {true, true, true, true, false}, {{x, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}}};
}

trace::Step step_at(Tick t) {
  trace::Step s;
  s.tick = t;
  s.target = {1.25F, -3};
  s.leaving = t > 1;
  s.live_hash = 0x123456789ABCDEF0ULL + static_cast<unsigned>(t);
  s.threshold = 0.3F;
  s.own_error = 0.01F;
  s.lateness = -250;
  s.replayed_steps = 44;
  s.snaps = 3;
  s.snap_m = 0.5;
  return s;
}

const Bytes kDatagram{std::byte{1}, std::byte{0}, std::byte{255}};

Bytes small_trace(bool footer = true) {
  Bytes out;
  trace::TraceWriter w(small_header(),
                       [&out](std::span<const std::byte> b) { out.insert(out.end(), b.begin(), b.end()); });
  w.confirmed(0, 99, truth_at(0, kNoPeer));
  w.step(step_at(0), view_at(0));
  w.received(16'667, kDatagram);
  w.confirmed(1, 100, truth_at(1, 1));
  w.step(step_at(1), view_at(0.5F));
  w.sent(2, 1, kDatagram);
  w.step(step_at(2), view_at(0.5F));
  if (!footer) return out;
  trace::Footer f;
  f.bundles = 4;
  f.updates_by_cause = {1, 2, 3};
  f.wire_bytes_sent = 1ULL << 40U;
  f.first_mismatch = -1;
  f.superseded = true;
  f.dropped_of = {{2, {0, 5}}};
  w.footer(f);
  return out;
}

/// What reading all of it says: empty, or the error.
std::string error_of(const Bytes& bytes) {
  try {
    trace::TraceReader r(bytes, "some.trace");
    while (r.next()) {
    }
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

std::size_t records_of(const Bytes& bytes, bool* truncated, bool* clean) {
  trace::TraceReader r(bytes, "some.trace");
  std::size_t n = 1;
  while (r.next()) ++n;
  *truncated = r.truncated();
  *clean = r.clean();
  return n;
}

TEST(TraceFormat, HeaderComesBackWhole) {
  const Bytes bytes = small_trace();
  const trace::TraceReader r(bytes, "some.trace");
  const trace::Header h = small_header();
  const trace::Header& got = r.header();
  EXPECT_EQ(got.program, h.program);
  EXPECT_EQ(got.revision, h.revision);
  EXPECT_EQ(got.command, h.command);
  EXPECT_EQ(got.scenario_text, h.scenario_text);
  EXPECT_EQ(got.scenario_seed, h.scenario_seed);
  EXPECT_EQ(got.netem, h.netem);
  EXPECT_EQ(got.netem_seed, h.netem_seed);
  EXPECT_EQ(got.input, h.input);
  EXPECT_EQ(got.start_unix_us, h.start_unix_us);
  EXPECT_EQ(got.peer, h.peer);
  EXPECT_EQ(got.peers, h.peers);
  EXPECT_EQ(got.slots, h.slots);
  EXPECT_EQ(got.session, h.session);
  EXPECT_EQ(got.session_id, h.session_id);
  EXPECT_EQ(got.scene_hash, h.scene_hash);
  EXPECT_EQ(got.fingerprint, h.fingerprint);
  EXPECT_EQ(got.bodies, h.bodies);
}

TEST(TraceFormat, EveryTechniqueComesBackWhole) {
  for (const auto name : technique_names()) {
    trace::Header h = small_header();
    h.technique = technique_by_name(name);
    const bool full = name == "full";
    h.technique.predictor = Predictor::kPcc;
    h.technique.law = ThresholdLaw::kContinuous;
    h.technique.convergence = Convergence::kPvb;
    h.technique.model = Model::kSecond;
    h.technique.pcc_bound = 0.7F;
    h.technique.count = 9;
    h.technique.precision = full ? Precision::kExact : Precision::kRounded;
    h.technique.unowned = full ? Unowned::kLive : Unowned::kAgreed;
    h.technique.time_stamps = full;
    Bytes bytes;
    trace::TraceWriter w(h, [&](std::span<const std::byte> b) { bytes.insert(bytes.end(), b.begin(), b.end()); });
    const Technique got = trace::TraceReader(bytes, "t").header().technique;
    EXPECT_EQ(got, h.technique) << name;
  }
}

TEST(TraceFormat, EventsComeBackInOrderAndExact) {
  const Bytes bytes = small_trace();
  trace::TraceReader r(bytes, "t");
  const auto c0 = std::get<trace::Confirmed>(r.next().value());
  EXPECT_EQ(c0.tick, 0);
  EXPECT_EQ(c0.hash, 99U);
  EXPECT_EQ(r.truth().owner, truth_at(0, kNoPeer).owner);
  EXPECT_EQ(std::get<trace::Step>(r.next().value()).tick, 0);
  EXPECT_EQ(r.live().states, view_at(0).states);
  EXPECT_TRUE(std::signbit(r.live().states[0].position.y)) << "-0 is told apart from 0";
  EXPECT_EQ(r.live().shown, view_at(0).shown);
  const auto in = std::get<trace::Received>(r.next().value());
  EXPECT_EQ(in.at, 16'667);
  EXPECT_EQ(Bytes(in.datagram.begin(), in.datagram.end()), kDatagram);
  EXPECT_EQ(std::get<trace::Confirmed>(r.next().value()).hash, 100U);
  EXPECT_EQ(r.truth().owner, truth_at(1, 1).owner);
  EXPECT_EQ(r.truth().present, truth_at(1, 1).present);
  EXPECT_EQ(r.truth().agreed, truth_at(1, 1).agreed);
  const auto s = std::get<trace::Step>(r.next().value());
  EXPECT_EQ(s.target, step_at(1).target);
  EXPECT_FALSE(s.leaving);
  EXPECT_EQ(s.live_hash, step_at(1).live_hash);
  EXPECT_EQ(s.threshold, 0.3F);
  EXPECT_EQ(s.own_error, 0.01F);
  EXPECT_EQ(s.lateness, -250);
  EXPECT_EQ(s.replayed_steps, 44U);
  EXPECT_EQ(s.snaps, 3U);
  EXPECT_EQ(s.snap_m, 0.5);
  EXPECT_EQ(r.live().states, view_at(0.5F).states);
  EXPECT_EQ(r.live().shown, view_at(0.5F).shown);
  const auto out = std::get<trace::Sent>(r.next().value());
  EXPECT_EQ(out.to, 2);
  EXPECT_EQ(out.tick, 1);
  EXPECT_EQ(Bytes(out.datagram.begin(), out.datagram.end()), kDatagram);
  EXPECT_TRUE(std::get<trace::Step>(r.next().value()).leaving);
  EXPECT_EQ(r.live().states, view_at(0.5F).states) << "nothing told, nothing changed";
  const auto f = std::get<trace::Footer>(r.next().value());
  EXPECT_EQ(f.updates_by_cause, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(f.wire_bytes_sent, 1ULL << 40U);
  ASSERT_EQ(f.dropped_of.size(), 1U);
  EXPECT_EQ(f.dropped_of[0].peer, 2);
  EXPECT_EQ(f.dropped_of[0].by_reason, (std::vector<std::uint64_t>{0, 5}));
  EXPECT_FALSE(r.next());
  EXPECT_TRUE(r.clean());
  EXPECT_FALSE(r.truncated());
}

TEST(TraceFormat, OnlyChangesAreTold) {
  Bytes bytes;
  std::size_t last = 0;
  trace::TraceWriter w(small_header(), [&](std::span<const std::byte> b) {
    last = b.size();
    bytes.insert(bytes.end(), b.begin(), b.end());
  });
  trace::LiveView v = view_at(0);
  v.shown[4] = v.states[4].position;
  w.step(step_at(0), v);
  const std::size_t whole = last;
  w.step(step_at(1), v);
  const std::size_t nothing = last;
  v.states[1].spin += 1;
  w.step(step_at(2), v);
  EXPECT_GT(whole, nothing + 5 * 8);
  EXPECT_LE(last, nothing + 3 + 3 + 6 + 2) << "one entity, one float, and that the peer is leaving";
}

TEST(TraceFormat, CutAtEveryByte) {
  const Bytes whole = small_trace();
  bool truncated = false;
  bool clean = false;
  const std::size_t all = records_of(whole, &truncated, &clean);
  EXPECT_EQ(all, 9U);
  EXPECT_TRUE(clean);
  std::size_t header_end = 0;
  std::size_t before = 0;
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
    const std::string error = error_of(cut);
    if (!error.empty()) {
      EXPECT_EQ(before, 0U) << "only an incomplete header is an error, cut at " << n << ": " << error;
      EXPECT_EQ(error.rfind("some.trace: ", 0), 0U) << error;
      header_end = n + 1;
      continue;
    }
    const std::size_t records = records_of(cut, &truncated, &clean);
    EXPECT_GE(records, before) << "cut at " << n;
    EXPECT_EQ(truncated, records == before) << "cut at " << n << ": between records nothing is cut off";
    EXPECT_FALSE(clean);
    before = records;
  }
  EXPECT_GT(header_end, 20U);
  EXPECT_EQ(before, all - 1);
}

TEST(TraceFormat, WhatIsNoTraceIsNamed) {
  const Bytes good = small_trace();
  Bytes newer = good;
  newer[7] = std::byte{7};
  Bytes older = good;
  older[7] = std::byte{5};
  Bytes after = good;
  after.push_back(std::byte{0});
  Bytes endless = small_trace(false);
  endless.insert(endless.end(), 6, std::byte{0xFF});
  Bytes unknown = small_trace(false);
  unknown.insert(unknown.end(), {std::byte{3}, std::byte{0xF8}, std::byte{1}, std::byte{1}});  // field 31, a number
  const auto text = [](std::string_view s) {
    Bytes b;
    for (const char c : s) b.push_back(static_cast<std::byte>(c));
    return b;
  };
  const std::vector<std::pair<Bytes, std::string>> cases{
      {{}, "some.trace: is empty, not a trace"},
      {text("t,x,y\n0,1,2\n"), "some.trace: not a trace of padr (it does not begin with PADRTRC)"},
      {text("\x0a\x0d\x0d\x0a\x1c\x01\x01\x01"),
       "some.trace: not a trace of padr (it does not begin with PADRTRC); it is a capture of packets, which "
       "padr-capture reads"},
      {text("PADR"), "some.trace: ends within the first 8 bytes"},
      {newer, "some.trace: trace format 7; this program reads format 6"},
      {older, "some.trace: trace format 5; this program reads format 6"},
      {text("PADRTRC\x06"), "some.trace: ends before its header is complete"},
      {after, "some.trace: record 10 at byte " + std::to_string(good.size()) + ": comes after the footer"},
      {endless, "some.trace: record 9 at byte " + std::to_string(endless.size() - 6) + ": its length makes no sense"},
      {unknown, "some.trace: record 9 at byte " + std::to_string(unknown.size() - 4) +
                    ": is of a kind that this program does not know"},
  };
  for (const auto& [bytes, expected] : cases) EXPECT_EQ(error_of(bytes), expected);
}

TEST(TraceFormat, StepsAndConfirmedTicksFollowOneAnother) {
  const auto with = [](const std::function<void(trace::TraceWriter&)>& write) {
    Bytes out;
    trace::TraceWriter w(small_header(),
                         [&out](std::span<const std::byte> b) { out.insert(out.end(), b.begin(), b.end()); });
    write(w);
    return error_of(out);
  };
  EXPECT_NE(with([](auto& w) { w.step(step_at(1), view_at(0)); }).find("step to tick 1 is out of turn"),
            std::string::npos);
  EXPECT_NE(with([](auto& w) { w.confirmed(3, 1, truth_at(0, 0)); }).find("confirmed tick 3 is out of turn"),
            std::string::npos);
  EXPECT_NE(with([](auto& w) { w.sent(0, 5, kDatagram); }).find("not the present one"), std::string::npos);
  // Once, one byte that had been changed made a report's means infinite.
  for (const float damaged : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30F})
    EXPECT_NE(with([damaged](auto& w) {
                trace::LiveView v = view_at(0);
                v.states[0].angle = damaged;
                w.step(step_at(0), v);
              }).find("the state of an entity is out of range"),
              std::string::npos)
        << damaged;
}

TEST(TraceFormat, EveryFlippedBitIsNoticed) {
  const Bytes whole = small_trace();
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    Bytes b = whole;
    b[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    if (!error_of(b).empty()) continue;
    bool truncated = false;
    bool clean = false;
    records_of(b, &truncated, &clean);
    EXPECT_FALSE(clean) << "bit " << bit % 8 << " of byte " << bit / 8;
  }
  Bytes b = whole;
  b[whole.size() / 2] ^= std::byte{1};
  EXPECT_NE(error_of(b).find("its checksum does not fit: the trace is damaged between byte "), std::string::npos)
      << error_of(b);
}

Bytes without_checksums(const Bytes& whole) {
  Bytes out(whole.begin(), whole.begin() + 8);
  google::protobuf::io::ArrayInputStream in(whole.data() + 8, static_cast<int>(whole.size() - 8));
  trace::file::Record record;
  while (google::protobuf::util::ParseDelimitedFromZeroCopyStream(&record, &in, nullptr)) {
    if (record.has_header()) record.mutable_header()->clear_checksum();
    if (record.has_step()) record.mutable_step()->clear_checksum();
    if (record.has_footer()) record.mutable_footer()->clear_checksum();
    const Bytes bytes = trace::delimited(record);
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  return out;
}

TEST(TraceFormat, TracesFromBeforeChecksumsAreRead) {
  EXPECT_EQ(error_of(without_checksums(small_trace())), "");
}

// By this, traces of two builds or processors are compared byte by byte.
TEST(TraceFormat, WhatFollowsTheHeaderDoesNotDependOnIt) {
  const auto after_header = [](const std::string& revision) {
    trace::Header header = small_header();
    header.revision = revision;
    std::vector<Bytes> written;
    trace::TraceWriter w(header,
                         [&written](std::span<const std::byte> b) { written.emplace_back(b.begin(), b.end()); });
    w.step(step_at(0), view_at(0));
    w.footer({});
    EXPECT_EQ(written.size(), 4U) << "preamble, header, step and footer";
    return written;
  };
  const std::vector<Bytes> one = after_header("one");
  const std::vector<Bytes> other = after_header("other");
  EXPECT_NE(one[1], other[1]);
  EXPECT_EQ(one[2], other[2]);
  EXPECT_EQ(one[3], other[3]);
}

// Damage is either refused in one line or read as something else, never worse. Without checksums it goes further.
TEST(TraceFormat, DamagedBytesAreSurvived) {
  const Bytes whole = without_checksums(small_trace());
  Rng rng(test::seed());
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    Bytes b = whole;
    for (std::uint32_t n = 1 + rng.below(4); n > 0; --n)
      b[8 + rng.below(static_cast<std::uint32_t>(b.size() - 8))] = static_cast<std::byte>(rng.below(256));
    const std::string error = error_of(b);
    if (error.empty()) continue;
    ++refused;
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace padr
