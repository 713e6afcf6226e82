// Traces of peers that come late, coordinate, are declared gone and come back.
#include <gtest/gtest.h>

#include <functional>

#include "common/model/user_error.h"
#include "common/trace/trace_reader.h"
#include "common/trace/trace_writer.h"
#include "tests/seed.h"
#include "tests/trace/recorded_lives.h"
#include "tools/lab/replay.h"

namespace padr {
namespace {

using Bytes = std::vector<std::byte>;

const Bytes kSome{std::byte{1}, std::byte{0}, std::byte{255}};

trace::Header late_header() {
  trace::Header h;
  h.peer = 2;
  h.slots = 3;
  h.incarnation = 4;
  h.bodies = 1;
  return h;
}

Bytes written(const trace::Header& h, const std::function<void(trace::TraceWriter&)>& write) {
  Bytes out;
  trace::TraceWriter w(h, [&out](std::span<const std::byte> b) { out.insert(out.end(), b.begin(), b.end()); });
  write(w);
  return out;
}

trace::LiveView nothing_moves() {
  trace::LiveView v;
  v.states.resize(4);
  v.shown.resize(4);
  return v;
}

trace::Truth nobody() {
  return {std::vector<PeerId>(4, kNoPeer), std::vector<bool>(4, true), std::vector<Vec2>(4)};
}

trace::Step step_to(Tick t) {
  trace::Step s;
  s.tick = t;
  s.outside = true;
  return s;
}

std::string error_in(const Bytes& bytes) {
  try {
    trace::TraceReader r(bytes, "t");
    while (r.next()) {
    }
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(TraceOfLives, WhatIsAskedOfANodeComesBackInOrder) {
  const Bytes bytes = written(late_header(), [&](trace::TraceWriter& w) {
    w.begin({900, 880, kSome});
    w.confirmed(880, 5, nobody());
    w.step(step_to(900), nothing_moves());
    w.freeze({0, true});
    w.give_up({1});
    w.order({kSome});
    w.excuse();
    w.step(step_to(901), nothing_moves());
    trace::Footer f;
    f.superseded = true;
    w.footer(f);
  });
  trace::TraceReader r(bytes, "t");
  EXPECT_EQ(r.header().incarnation, 4U);
  EXPECT_EQ(r.header().peer, 2) << "above the peers at tick 0, of which a late one knows nothing";
  const auto begin = std::get<trace::Begin>(r.next().value());
  EXPECT_EQ(begin.tick, 900);
  EXPECT_EQ(begin.confirmed, 880);
  EXPECT_EQ(Bytes(begin.transfer.begin(), begin.transfer.end()), kSome);
  EXPECT_EQ(std::get<trace::Confirmed>(r.next().value()).tick, 880);
  EXPECT_TRUE(std::get<trace::Step>(r.next().value()).outside);
  const auto freeze = std::get<trace::Freeze>(r.next().value());
  EXPECT_EQ(freeze.peer, 0);
  EXPECT_TRUE(freeze.frozen);
  EXPECT_EQ(std::get<trace::GiveUp>(r.next().value()).peer, 1);
  const auto order = std::get<trace::Order>(r.next().value());
  EXPECT_EQ(Bytes(order.fetched.begin(), order.fetched.end()), kSome);
  EXPECT_TRUE(std::holds_alternative<trace::Excuse>(r.next().value()));
  EXPECT_EQ(std::get<trace::Step>(r.next().value()).tick, 901);
  EXPECT_TRUE(std::get<trace::Footer>(r.next().value()).superseded);
}

// Nobody has the keys any more: own signatures are in the trace, others' have been checked before it.
TEST(TraceOfLives, SealedOnesReplayWithoutKeys) {
  const test::RecordedLives run(test::seed(), wire::SealMode::kAuth);
  int incarnations = 0;
  for (const auto& [key, bytes] : run.traces) {
    trace::TraceReader reader(bytes, run.label(key));
    EXPECT_TRUE(reader.header().is_signed);
    const lab::ReplayResult r = lab::replay(reader);
    EXPECT_EQ(r.difference, "") << run.label(key);
    EXPECT_GT(r.datagrams_out, 0U) << run.label(key);
    ++incarnations;
  }
  EXPECT_GT(incarnations, 4);
}

TEST(TraceOfLives, WhatMakesNoSenseIsNamed) {
  trace::Header first = late_header();
  first.incarnation = 0;
  first.peer = 0;
  trace::Header beyond = late_header();
  beyond.peer = 3;
  const std::vector<std::pair<Bytes, std::string>> cases{
      {written(late_header(), [](auto& w) { w.step(step_to(0), nothing_moves()); }),
       "is not what one who came later begins with"},
      {written(first,
               [](auto& w) {
                 w.begin({0, 0, kSome});
               }),
       "begins where something has begun"},
      {written(late_header(),
               [](auto& w) {
                 w.begin({9, 8, kSome});
                 w.begin({9, 8, kSome});
               }),
       "begins where something has begun"},
      {written(late_header(),
               [](auto& w) {
                 w.begin({8, 9, kSome});
               }),
       "begins at a tick that makes no sense"},
      {written(late_header(),
               [](auto& w) {
                 w.begin({9, 8, kSome});
                 w.step(step_to(8), nothing_moves());
               }),
       "step to tick 8 is out of turn"},
      {written(late_header(),
               [](auto& w) {
                 w.begin({9, 8, kSome});
                 w.confirmed(9, 1, nobody());
               }),
       "confirmed tick 9 is out of turn"},
      {written(first,
               [](auto& w) {
                 w.freeze({3, true});
               }),
       "freezes no slot"},
      {written(first, [](auto& w) { w.give_up({3}); }), "gives up no slot"},
      {written(beyond, [](auto&) {}), "peer 3, allowed: below the number of slots"},
  };
  for (const auto& [bytes, expected] : cases)
    EXPECT_NE(error_in(bytes).find(expected), std::string::npos) << expected << ", found: " << error_in(bytes);
}

TEST(TraceOfLives, EveryLifeOfEverybodyDoesTheSameAgain) {
  const test::RecordedLives run(test::seed());
  int late = 0;
  std::map<std::string, int> asked;
  for (const auto& [key, bytes] : run.traces) {
    SCOPED_TRACE(run.label(key));
    trace::TraceReader reader(bytes, run.label(key));
    const lab::ReplayResult r = lab::replay(reader);
    EXPECT_EQ(r.difference, "");
    EXPECT_GT(r.confirmed, 100U);
    EXPECT_GT(r.datagrams_out, 20U);
    if (reader.header().incarnation > 0) ++late;
    trace::TraceReader again(bytes, "t");
    while (const auto e = again.next()) {
      if (std::holds_alternative<trace::Order>(*e)) ++asked["order"];
      if (std::holds_alternative<trace::Freeze>(*e)) ++asked["freeze"];
    }
  }
  EXPECT_EQ(run.traces.size(), 6U) << "five persons, one of whom came back";
  EXPECT_EQ(late, 5) << "all but the founder";
  EXPECT_GE(asked["order"], 7) << "five came in, two were removed";
  EXPECT_GE(asked["freeze"], 4);
}

TEST(TraceOfLives, AnOrderThatIsLeftOutIsMissed) {
  const test::RecordedLives run(test::seed());
  const Bytes& whole = run.traces.at({0, 0});  // the coordinator's
  trace::TraceReader r(whole, "t");
  bool left_out = false;
  const Bytes changed = written(r.header(), [&](trace::TraceWriter& w) {
    while (const auto e = r.next()) {
      if (const auto* s = std::get_if<trace::Step>(&*e)) w.step(*s, r.live());
      if (const auto* in = std::get_if<trace::Received>(&*e)) w.received(in->at, in->datagram);
      if (const auto* out = std::get_if<trace::Sent>(&*e)) w.sent(out->to, out->tick, out->datagram);
      if (const auto* c = std::get_if<trace::Confirmed>(&*e)) w.confirmed(c->tick, c->hash, r.truth());
      if (const auto* f = std::get_if<trace::Freeze>(&*e)) w.freeze(*f);
      if (std::holds_alternative<trace::Excuse>(*e)) w.excuse();
      if (const auto* o = std::get_if<trace::Order>(&*e); o != nullptr && std::exchange(left_out, true)) w.order(*o);
    }
  });
  ASSERT_TRUE(left_out);
  trace::TraceReader reader(changed, "t");
  EXPECT_NE(lab::replay(reader).difference, "");
}

TEST(TraceOfLives, ABeginningThatDoesNotDecodeIsSaid) {
  trace::TraceReader whole(test::RecordedLives(test::seed()).traces.at({3, 0}), "t");
  const Bytes changed = written(whole.header(), [](auto& w) { w.begin({900, 880, kSome}); });
  trace::TraceReader reader(changed, "some.trace");
  try {
    lab::replay(reader);
    FAIL();
  } catch (const UserError& e) {
    EXPECT_STREQ(e.what(), "some.trace: the agreed world that it begins with does not decode");
  }
}

}  // namespace
}  // namespace padr
