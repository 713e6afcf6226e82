#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/model/rng.h"
#include "common/wire/codec.h"
#include "common/wire/session_codec.h"
#include "tests/seed.h"
#include "tools/capture/record.h"
#include "tools/capture/tally.h"

namespace padr::capture {
namespace {

TEST(NumberWindow, CountsNewLateAgainAndMissing) {
  using Seen = NumberWindow::Seen;
  NumberWindow w;
  EXPECT_EQ(w.missing(), 0U);
  EXPECT_EQ(w.add(10), Seen::kNew);
  EXPECT_EQ(w.add(12), Seen::kNew);
  EXPECT_EQ(w.missing(), 1U);
  EXPECT_EQ(w.add(12), Seen::kAgain);
  EXPECT_EQ(w.add(11), Seen::kNewLate);
  EXPECT_EQ(w.add(8), Seen::kNewLate) << "before the first seen";
  EXPECT_EQ(w.missing(), 1U) << "9";
  EXPECT_EQ(w.add(12 + 4095), Seen::kNew);
  EXPECT_EQ(w.add(12), Seen::kAgain) << "just within reach";
  EXPECT_EQ(w.add(13), Seen::kNewLate);
  EXPECT_EQ(w.add(11), Seen::kAgain) << "too old to tell";
  EXPECT_EQ(w.add(100000), Seen::kNew);
  EXPECT_EQ(w.add(100000 - 4095), Seen::kNewLate) << "a leap leaves nothing of before behind";
  EXPECT_EQ(w.distinct(), 8U);
  EXPECT_EQ(w.missing(), 100000U - 8 + 1 - 8);
}

// As a receiver tells it: of the 200 latest numbers without the newest 8, in whole per cent, rounded down. The loss
// comes in the second half alone, and little is told then: a mean of what is told is far from it.
TEST(ToldLoss, CountsEveryNumberOnce) {
  std::vector<bool> lost(2001);
  std::size_t all = 0;
  for (std::size_t n = 1001; n <= 2000; ++n) {
    lost[n] = n % 5 == 0;
    all += lost[n] ? 1U : 0U;
  }
  ToldLoss told;
  double sum = 0;
  int tellings = 0;
  for (std::uint32_t highest = 1; highest <= 2000; ++highest) {
    if (highest % (highest <= 1000 ? 2 : 50) != 0) continue;
    std::uint32_t missing = 0;
    std::uint32_t of = 0;
    for (std::uint32_t back = 8; back < std::min(200U, highest); ++back, ++of)
      missing += lost[highest - back] ? 1U : 0U;
    const std::uint32_t percent = of < 8 ? 0 : 100 * missing / of;
    told.add(1, highest, percent);
    sum += percent;
    ++tellings;
  }
  EXPECT_LT(sum / tellings, 2);
  EXPECT_EQ(told.of(), 2000U - 8);
  EXPECT_NEAR(told.percent(), 100.0 * static_cast<double>(all) / 2000, 1);
}

TEST(NumberWindow, WhatIsMissingIsAPartOfItsSpan) {
  NumberWindow w;
  EXPECT_EQ(w.span(), 0U);
  w.add(7);
  w.add(10);
  EXPECT_EQ(w.span(), 4U);
  EXPECT_EQ(w.missing(), 2U);
}

TEST(Gaps, PercentilesAreWithinThreePercent) {
  Gaps g;
  for (std::int64_t us = 1; us <= 100000; ++us) g.add(us);
  EXPECT_NEAR(g.percentile_us(0.5), 50000, 1500);
  EXPECT_NEAR(g.percentile_us(0.95), 95000, 2850);
  EXPECT_DOUBLE_EQ(g.mean_us(), 50000.5);
  Gaps small;
  for (std::int64_t us : {0, 3, 63, 64, 65}) small.add(us);
  EXPECT_EQ(small.percentile_us(0.5), 63);
  EXPECT_EQ(small.percentile_us(0.2), 0);
  Gaps huge;
  huge.add(std::int64_t{1} << 60U);
  EXPECT_GT(huge.percentile_us(0.5), 5e11) << "all that is longer than a week counts as that";
}

/// Percentiles against those of the values in order. A value is in the middle of its step.
void expect_exact(std::vector<std::int64_t> us, double within_us) {
  Delays d;
  for (const std::int64_t v : us) d.add(v);
  std::sort(us.begin(), us.end());
  for (const double share : {0.01, 0.5, 0.95, 0.99, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(us.size())));
    EXPECT_NEAR(d.percentile_us(share), static_cast<double>(us[rank - 1]), within_us) << share;
  }
  EXPECT_EQ(d.least_us(), us.front());
}

// Once, what was more than 0.5 s below the first delay counted as that.
TEST(Delays, OfALinkWhoseFirstDatagramsWaitInAQueue) {
  std::vector<std::int64_t> us;
  for (int i = 0; i < 100; ++i) us.push_back(1'700'000'000'000'000 + 4'000'000 - 40'000 * i);
  for (int i = 0; i < 10'000; ++i) us.push_back(1'700'000'000'000'000 + 50'000 + 7 * (i * 37 % 10'000));
  expect_exact(us, 125);
}

TEST(Delays, AreExactToAThousandthOfTheirSpread) {
  Rng rng(test::seed(1));
  std::vector<std::int64_t> us(30'000);
  for (std::int64_t& v : us) v = std::llround(rng.uniform(100'000, 2'900'000));  // delay 1500ms 1400ms
  expect_exact(us, 500);
  for (std::int64_t& v : us) v -= 1'500'000;
  expect_exact(us, 500);
}

TEST(Delays, AnOutlierCostsNoPrecision) {
  std::vector<std::int64_t> us{-3'600'000'000};
  for (int i = 0; i < 4000; ++i) us.push_back(i * 50);
  expect_exact(us, 125);
}

/// One peer's datagrams to another, as a capture has them.
class Talk {
 public:
  Talk() {
    a_ = padr::ipv4({}, 1);
    b_ = padr::ipv4({}, 2);
  }
  sync::StatePacket packet(std::uint32_t seq, Tick tick, std::uint32_t count) const {
    sync::StatePacket p;
    p.seq = seq;
    p.mark_tick = tick;
    p.mark_count = count;
    return p;
  }
  static sync::Bundle bundle(std::uint32_t index, Tick tick) {
    sync::Bundle b;
    b.index = index;
    b.tick = tick;
    b.avatar.emplace();
    sync::BodyUpdate u;
    u.body = 7;
    u.cause = sync::Cause::kContactBegin;
    b.bodies = {u};
    return b;
  }
  void say(PeerId from, const sync::StatePacket& p, std::int64_t at_us) {
    bytes_ = wire::seal({wire::Kind::kState, from, 77}, wire::encode(p));
    hear(from, at_us);
  }
  void say(PeerId from, const wire::SessionMessage& m, std::int64_t at_us) {
    bytes_ = wire::seal({wire::Kind::kSession, from, 77}, wire::encode_session(m));
    hear(from, at_us);
  }
  void hear(PeerId from, std::int64_t at_us) {
    Datagram d;
    d.from = from == 0 ? a_ : b_;
    d.to = from == 0 ? b_ : a_;
    d.time_ns = at_us * 1000;
    d.payload = bytes_;
    d.wire_bytes = bytes_.size() + 28;
    tally.take(d);
    if (from == 0) wire_bytes += d.wire_bytes;
  }
  const LinkTally& link(PeerId from) const {
    for (const auto& [key, l] : tally.links())
      if (key.from.slot == from) return l;
    throw std::logic_error("no such link");
  }
  Tally tally;
  std::size_t wire_bytes = 0;
  wire::Bytes bytes_;

 private:
  Endpoint a_, b_;
};

TEST(Tally, LossDuplicatesReorderingResendsAndAcks) {
  Talk t;
  auto p = t.packet(1, 60, 1);
  p.updates = {Talk::bundle(0, 60)};
  t.say(0, p, 1'000'000 + 5'000);
  t.say(0, t.packet(3, 90, 1), 1'500'000 + 9'000);  // 2 is late
  p.seq = 2;
  p.mark_tick = 75;
  t.say(0, p, 1'510'000);  // carries the update again
  t.say(0, p, 1'511'000);  // and is duplicated
  t.say(0, t.packet(6, 120, 1), 2'000'000 + 5'000);
  auto ack = t.packet(1, 121, 0);
  ack.have = 1;
  ack.transit = 432;
  ack.loss = 7;
  t.say(1, ack, 2'105'000);

  const LinkTally& l = t.link(0);
  EXPECT_EQ(l.traffic.datagrams, 5U);
  EXPECT_EQ(l.seqs.missing(), 2U) << "4 and 5";
  EXPECT_EQ(l.duplicates, 1U);
  EXPECT_EQ(l.reordered, 1U);
  EXPECT_EQ(l.marks, 2U);
  EXPECT_EQ(l.repeats, 1U) << "what a duplicate carries is not sent again";
  EXPECT_EQ(l.transit, 432);
  EXPECT_EQ(l.told_loss.of(), 0U) << "of six datagrams nothing is judged";
  EXPECT_EQ(l.acks.count(), 1U);
  EXPECT_NEAR(l.acks.mean_us(), 1'100'000, 1);
  EXPECT_EQ(t.tally.incarnations().at({77, 0, 0}).updates[static_cast<std::size_t>(sync::Cause::kContactBegin)], 1U);
  EXPECT_EQ(t.tally.incarnations().at({77, 0, 0}).updates[static_cast<std::size_t>(sync::Cause::kThreshold)], 1U);
  const Traffic& f = l.traffic;
  EXPECT_EQ(f.bytes, t.wire_bytes);
  EXPECT_EQ(f.bytes, f.header_bytes + f.envelope_bytes + f.update_bytes + f.repeat_bytes + f.mark_bytes);
  EXPECT_EQ(f.header_bytes, 5U * 28);
  EXPECT_EQ(f.repeat_bytes, 2 * (f.update_bytes + 2)) << "how far back its tick lies takes two bytes";
  // Without Pongs the fastest datagram has taken no time: that is 4 to 6 ms after the beginning of its tick.
  EXPECT_FALSE(t.tally.tick0(77).second);
  EXPECT_EQ(t.tally.tick0(77).first, 5'000);
  EXPECT_EQ(l.delays.least_us(), 5'000);
}

/// A capture beside peer 1, which asks: Pings are in it 40 ms before they are answered. Peer 0's datagrams take
/// `way_us`.
Talk beside_the_asker(std::int64_t way_us, int datagrams, std::int32_t told) {
  constexpr std::int64_t kZero = 5'000'000;
  Talk t;
  t.say(1, wire::Ping{111}, kZero + 900'000);
  t.say(0, wire::Pong{111, 940'000}, kZero + 980'000);
  auto p = t.packet(1, 0, 0);
  for (int i = 0; i < datagrams; ++i, ++p.seq) {
    p.mark_tick = 60 + 6 * i;
    t.say(0, p, kZero + tick_start(p.mark_tick) + way_us);
  }
  auto back = t.packet(1, 60, 0);
  back.transit = told;
  t.say(1, back, kZero + tick_start(60));
  return t;
}

// Once, delays in a joiner's capture were too long by the way that its Pings took.
TEST(Tally, ADelayToTheCaptureIsNotLongerThanTheReceiverTells) {
  const auto least = [](const Talk& t) { return t.link(0).delays.least_us() - t.tally.tick0(77).first; };
  EXPECT_TRUE(beside_the_asker(40'000, 30, 400).tally.tick0(77).second);
  EXPECT_NEAR(static_cast<double>(least(beside_the_asker(40'000, 30, 400))), 40'000, 1);
  EXPECT_NEAR(static_cast<double>(least(beside_the_asker(40'000, 5, 400))), 80'000, 1) << "too few to judge by";
  EXPECT_NEAR(static_cast<double>(least(beside_the_asker(40'000, 30, 760))), 80'000, 1) << "as clocks differ";
  EXPECT_NEAR(static_cast<double>(least(beside_the_asker(10'000, 30, 700))), 50'000, 1) << "it is on the way";
}

// Once, the sizes of datagrams that had been sealed were those without the seal, and only their mean was with it.
TEST(Tally, SizesAreWithTheSeal) {
  Talk t;
  const wire::Bytes bytes = wire::seal({wire::Kind::kState, 0, 77}, wire::encode(t.packet(1, 60, 0)));
  Datagram d;
  d.payload = bytes;
  d.seal_bytes = 20;
  d.wire_bytes = bytes.size() + 20 + 28;
  t.tally.take(d);
  EXPECT_EQ(t.tally.all().least_size, bytes.size() + 20);
  EXPECT_EQ(t.tally.all().most_size, bytes.size() + 20);
}

TEST(Tally, DamagedIsCountedByReason) {
  Talk t;
  t.say(0, t.packet(1, 60, 0), 1);
  t.bytes_[8] ^= std::byte{1};
  t.hear(0, 2);
  t.bytes_.resize(7);
  t.hear(0, 3);
  t.bytes_ = wire::seal({wire::Kind::kState, 0, 77}, {});
  t.hear(0, 4);
  EXPECT_EQ(t.tally.dropped(), (std::map<std::string, std::uint64_t>{{"malformed", 1}, {"short", 1}, {"tag", 1}}));
  EXPECT_EQ(t.tally.all().datagrams, 4U);
}

TEST(Record, EveryFieldHasAPlaceInTheTable) {
  // A record whose name is missing from the table would be left out of CSV.
  Talk t;
  auto p = t.packet(1, 60, 1);
  p.check_tick = 30;
  p.check_hash = 0xABCDEF01;
  p.updates = {Talk::bundle(0, 60)};
  p.updates[0].bodies[0].has_state = true;
  p.updates[0].bodies[0].epoch = 1;
  t.say(0, p, 5);
  Datagram d;
  d.payload = t.bytes_;
  d.from = d.to = d.outer_from = d.outer_to = padr::ipv4({}, 0);
  d.carried_to = 0xABCDEF01;
  d.time_ns = 1'000'000'007;
  Recorder recorder;
  const Record r = recorder.record(d);
  const std::string json = r.json();
  EXPECT_NE(json.find("\"frame.time_epoch\":\"1.000000007\""), std::string::npos) << json;
  EXPECT_NE(json.find("\"padr.carried.to\":\"abcdef01\""), std::string::npos) << json;
  EXPECT_NE(json.find("\"padr.cause\":[\"threshold\",\"contact_begin\"]"), std::string::npos) << json;
  EXPECT_NE(json.find("\"padr.check_hash\":\"abcdef01\""), std::string::npos) << json;
  std::size_t names = 0;
  for (std::size_t at = 0; (at = json.find("\":", at)) != std::string::npos; ++at) ++names;
  std::size_t found = 0;
  for (const std::string_view name : all_fields()) found += r.find(name) != nullptr ? 1U : 0U;
  EXPECT_EQ(names, found) << json;
}

// By the ranges of proto/WIRE.md, section 4, that are the same in every scenario. Once, only what is not finite was.
TEST(Record, WhatEveryPeerDropsForItsValueIsMarked) {
  using Change = void (*)(sync::Bundle&);
  const auto dropped = [](Change change) {
    Talk t;
    auto p = t.packet(1, 60, 1);
    p.updates = {Talk::bundle(0, 60)};
    p.updates[0].avatar->model = Model::kSecond;
    p.updates[0].avatar->awake = true;
    sync::BodyUpdate& u = p.updates[0].bodies[0];
    u.has_state = u.state.awake = true;
    u.epoch = 1;
    change(p.updates[0]);
    t.say(0, p, 5);
    Datagram d;
    d.payload = t.bytes_;
    Recorder recorder;
    const Record r = recorder.record(d);
    return r.json().find("\"padr.drop\":\"value\"") != std::string::npos;
  };
  const std::vector<std::pair<Change, bool>> cases{
      {[](sync::Bundle&) {}, false},
      {[](sync::Bundle& b) { b.bodies[0].epoch = 0; }, true},
      {[](sync::Bundle& b) { b.bodies[0].state.position.x = -1e6F; }, false},  // some scenario may have it
      {[](sync::Bundle& b) { b.bodies[0].state.velocity.x = 121; }, false},
      {[](sync::Bundle& b) { b.bodies[0].state.velocity.x = b.bodies[0].state.velocity.y = 100; }, true},
      {[](sync::Bundle& b) { b.bodies[0].state.spin = -95; }, false},
      {[](sync::Bundle& b) { b.bodies[0].state.spin = 95.5F; }, true},
      {[](sync::Bundle& b) { b.bodies[0].state.angle = -1.1e5F; }, true},
      {[](sync::Bundle& b) { b.avatar->velocity.y = 122; }, true},
      {[](sync::Bundle& b) { b.avatar->control.x = 9000; }, false},
      {[](sync::Bundle& b) { b.avatar->control.x = b.avatar->control.y = 9000; }, true},
      {[](sync::Bundle& b) { b.avatar->velocity.y = 1; }, false},
      {[](sync::Bundle& b) { b.avatar->awake = (b.avatar->velocity.y = 1) < 1; }, true},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) EXPECT_EQ(dropped(cases[i].first), cases[i].second) << "case " << i;
}

}  // namespace
}  // namespace padr::capture
