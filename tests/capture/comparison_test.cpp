#include "tools/capture/comparison.h"

#include <functional>
#include <string>

#include "common/model/user_error.h"
#include "common/trace/trace_writer.h"
#include "common/wire/codec.h"
#include "common/wire/seal.h"
#include "tests/shell.h"

// A capture against the traces of a sender, peer 0, and a receiver, peer 1.
namespace padr::capture {
namespace {

constexpr std::uint16_t kSession = 5;
constexpr Tick kSent = 600;  ///< a datagram each tick, of which all arrive

class ComparisonTest : public test::Shell {
 protected:
  /// `seq`: and the tick, too.
  static wire::Bytes datagram(std::uint32_t seq, PeerId from = 0) {
    sync::StatePacket p;
    p.seq = seq;
    p.mark_tick = static_cast<Tick>(seq);
    return wire::seal({wire::Kind::kState, from, kSession}, wire::encode(p));
  }
  /// `until`: of a trace that breaks off, its last tick.
  void trace_of(PeerId peer, Comparison& c, Tick until = 0) const {
    std::string text;
    trace::Header h;
    h.peer = peer;
    h.peers = h.slots = 2;
    h.session = kSession;
    trace::TraceWriter w(
        h, [&](std::span<const std::byte> b) { text.append(reinterpret_cast<const char*>(b.data()), b.size()); });
    const trace::LiveView nothing{std::vector<BodyState>(2), std::vector<Vec2>(2)};
    w.step({}, nothing);
    for (Tick t = 1; t <= (until > 0 ? until : kSent); ++t) {
      trace::Step step;
      step.tick = t;
      w.step(step, nothing);
      const wire::Bytes d = datagram(static_cast<std::uint32_t>(t));
      if (peer == 0) w.sent(1, t, d);
      if (peer == 1) w.received(t, d);
    }
    if (peer == 1) w.sent(0, until > 0 ? until : kSent, datagram(1, 1));
    if (until == 0) w.footer({});
    const std::string name = "peer" + std::to_string(peer) + ".trace";
    write(name, text);
    c.add_trace(path(name));
  }
  static Endpoint end(PeerId peer) {
    Endpoint e;
    e.port = static_cast<std::uint16_t>(4001 + peer);
    return e;
  }
  static void capture(const wire::Bytes& payload, PeerId from, Comparison& c, bool cut = false, int hops = 0) {
    Datagram d;
    d.cut = cut;
    if (hops > 0) d.carried_to = 7;
    d.from = end(from);
    d.to = end(1 - from);
    d.payload = payload;
    c.add(d);
    d.second_hop = true;
    if (hops > 1) c.add(d);
  }
  /// Of peer 0's datagrams, those for which `has` says so; of peer 1's, if `both`, the one that tells who it is.
  LinkStory link(const std::function<bool(Tick)>& has, bool both = true) const {
    Comparison c;
    trace_of(0, c);
    trace_of(1, c);
    if (both) capture(datagram(1, 1), 1, c);
    for (Tick t = 1; t <= kSent; ++t)
      if (has(t)) capture(datagram(static_cast<std::uint32_t>(t)), 0, c);
    for (const LinkStory& l : c.links())
      if (l.from.slot == 0) return l;
    ADD_FAILURE() << "no link from peer 0";
    return {};
  }
};

// The network turns the order of datagrams round: where a capture begins or ends, an older one may be in it and a newer
// one not.
TEST_F(ComparisonTest, OrderAtTheEdgesOfACaptureIsNoContradiction) {
  const LinkStory begins = link([](Tick t) { return t >= 200 && t != 201; });
  EXPECT_TRUE(begins.contradictions.empty());
  EXPECT_EQ(begins.outside, 200U);
  const LinkStory ends = link([](Tick t) { return t <= 400 && t != 399; });
  EXPECT_TRUE(ends.contradictions.empty());
  EXPECT_EQ(ends.outside, 201U);
}

TEST_F(ComparisonTest, WhatArrivedAndIsMissingInTheMiddleContradicts) {
  const LinkStory l = link([](Tick t) { return t >= 200 && t != 400; });
  ASSERT_EQ(l.contradictions.size(), 1U);
  EXPECT_EQ(l.contradictions.front().tick, 400);
}

// A carrier's capture has a link's datagrams only while it carries. Once, those that went directly meanwhile
// contradicted it.
TEST_F(ComparisonTest, WhatACarrierDidNotPassOnIsNoContradiction) {
  const auto compared = [&](bool carrier, bool sender) {
    Comparison c;
    trace_of(0, c);
    trace_of(1, c);
    capture(datagram(1, 1), 1, c);
    for (Tick t = 1; t <= kSent; ++t) {
      const bool carried = (t > 100 && t < 200) || t > 500;
      const int hops = (sender ? 1 : 0) + (carrier ? 2 : 0);
      if (carried && hops > 0) capture(datagram(static_cast<std::uint32_t>(t)), 0, c, false, hops);
      if (!carried && sender && t != 300) capture(datagram(static_cast<std::uint32_t>(t)), 0, c);
    }
    return c.links()[0];
  };
  const LinkStory between = compared(true, false);
  EXPECT_TRUE(between.contradictions.empty());
  EXPECT_EQ(between.captured, 199U);
  EXPECT_EQ(between.outside, 401U);
  // Where the direct ones were captured, one that is missing among them still does.
  for (const bool carrier : {false, true}) EXPECT_EQ(compared(carrier, true).contradictions.size(), 1U);
}

// Once, this was damage and a contradiction.
TEST_F(ComparisonTest, WhatTheCaptureHasCutOffIsNotJudged) {
  Comparison c;
  trace_of(0, c);
  trace_of(1, c);
  for (Tick t = 1; t <= kSent; ++t) {
    wire::Bytes d = datagram(static_cast<std::uint32_t>(t));
    const bool cut = t % 3 == 0;
    if (cut) d.resize(d.size() - 4);
    capture(d, 0, c, cut);
  }
  capture(datagram(1, 1), 1, c);
  EXPECT_EQ(c.cut(), 200U);
  EXPECT_EQ(c.damaged(), 0U);
  const std::vector<LinkStory> links = c.links();
  ASSERT_EQ(links.size(), 2U);
  EXPECT_EQ(links[0].cut, 200U);
  EXPECT_EQ(links[0].captured, 400U);
  EXPECT_TRUE(links[0].contradictions.empty());
  EXPECT_TRUE(links[0].lost_before.empty());
  EXPECT_EQ(links[1].cut, 0U);
  EXPECT_EQ(links[1].captured, 1U);
}

// Once, all that came after a receiver's crash counted as lost.
TEST_F(ComparisonTest, WhatATraceThatBreaksOffCannotTellIsNotLost) {
  constexpr Tick kBrokeOff = 300;
  Comparison c;
  trace_of(0, c);
  trace_of(1, c, kBrokeOff);
  capture(datagram(1, 1), 1, c);
  for (Tick t = 1; t <= kSent; ++t) capture(datagram(static_cast<std::uint32_t>(t)), 0, c);
  EXPECT_FALSE(c.traces()[1].clean);
  for (const LinkStory& l : c.links()) {
    if (l.from.slot != 0) continue;
    EXPECT_TRUE(l.lost_after.empty());
    EXPECT_TRUE(l.contradictions.empty());
    EXPECT_EQ(l.after_trace.size(), static_cast<std::size_t>(kSent - kBrokeOff));
  }
}

// Once, all that it tells counted twice, and contradicted the capture.
TEST_F(ComparisonTest, ATraceIsTakenOnce) {
  Comparison c;
  trace_of(0, c);
  try {
    trace_of(0, c);
    FAIL() << "taken twice";
  } catch (const UserError& e) {
    EXPECT_EQ(e.what(), path("peer0.trace") + ": is a trace of peer 0, and so is " + path("peer0.trace"));
  }
}

// Whoever has left sends nothing more, and gets more for a while.
TEST_F(ComparisonTest, WhatIsSentToSomebodyWhoSaysNothingIsNoContradiction) {
  const LinkStory l = link([](Tick t) { return t >= 500; }, false);
  EXPECT_EQ(l.to.slot, 1);
  EXPECT_TRUE(l.contradictions.empty());
  EXPECT_EQ(l.captured, 101U);
}

}  // namespace
}  // namespace padr::capture
