#include <gtest/gtest.h>

#include "shell/text.h"
#include "tools/report/confirmed_ticks.h"
#include "tools/report/link_meter.h"
#include "tools/report/outputs.h"
#include "tools/report/traffic.h"

namespace padr {
namespace {

TEST(LinkMeter, WorkedOutByHand) {
  report::LinkMeter m;
  // Ticks 0, 6, 12, ... start every 100 ms. Of six datagrams the third is lost, the fourth overtakes the second, the
  // fifth comes twice; the sixth is sent in the receiver's last second.
  for (std::uint32_t i = 0; i < 6; ++i) m.sent(i + 1, static_cast<Tick>(6 * i));
  m.received(1, 0, 50'000);
  m.received(4, 18, 310'000);
  m.received(2, 6, 320'000);
  m.received(5, 24, 430'000);
  m.received(5, 24, 440'000);
  const report::Link l = m.result(0, 1, 30 + 59);
  EXPECT_EQ(l.sent, 6U);
  EXPECT_EQ(l.received, 4U);
  EXPECT_EQ(l.duplicates, 1U);
  EXPECT_EQ(l.reordered, 1U);
  EXPECT_EQ(l.judged, 5U);
  EXPECT_EQ(l.lost, 1U);
  EXPECT_DOUBLE_EQ(l.loss_percent(), 20);
  EXPECT_DOUBLE_EQ(l.reordered_percent(), 25);
  // Delays 50, 10, 220, 30 ms.
  EXPECT_DOUBLE_EQ(l.delay_mean_ms, 77.5);
  EXPECT_DOUBLE_EQ(l.delay_p50_ms, 30);
  EXPECT_DOUBLE_EQ(l.delay_p95_ms, 220);
  EXPECT_DOUBLE_EQ(l.jitter_ms, (40.0 + 210 + 190) / 3);
  EXPECT_EQ(m.result(0, 1, 30 + 60).judged, 6U) << "a tick later the sixth counts too, as lost";
}

TEST(LinkMeter, NothingSentIsNothingLost) {
  const report::Link l = report::LinkMeter().result(0, 1, 100);
  EXPECT_EQ(l.loss_percent(), 0);
  EXPECT_EQ(l.reordered_percent(), 0);
}

// Once, it had a delay of 0 ms.
TEST(LinkMeter, WhatNeverArrivedHasNoDelay) {
  report::LinkMeter m;
  m.sent(1, 0);
  const report::Link l = m.result(0, 1, 100);
  EXPECT_EQ(l.lost, 1U);
  for (const double none : {l.delay_mean_ms, l.delay_p50_ms, l.delay_p95_ms, l.jitter_ms})
    EXPECT_TRUE(std::isnan(none));
  m.received(1, 0, 50'000);
  EXPECT_DOUBLE_EQ(m.result(0, 1, 100).delay_mean_ms, 50);
  EXPECT_TRUE(std::isnan(m.result(0, 1, 100).jitter_ms)) << "one datagram has no jitter";
}

sync::Bundle bundle(std::uint32_t index) {
  sync::Bundle b;
  b.index = index;
  b.avatar = sync::AvatarUpdate{};
  b.avatar->cause = sync::Cause::kContactBegin;
  sync::BodyUpdate u;
  u.body = 3;
  u.cause = sync::Cause::kProxy;
  u.has_state = true;
  b.bodies.push_back(u);
  return b;
}

TEST(TrafficMeter, EachUpdateOncePerSenderRepeatsPerReceiver) {
  report::TrafficMeter m;
  sync::StatePacket p;
  p.mark_tick = 90;
  p.mark_count = 2;
  p.updates = {bundle(0)};
  m.sent(1, 0, p, 200);   // new
  m.sent(2, 0, p, 200);   // the same to another: no new update, no repeat
  m.sent(1, 59, p, 200);  // a repeat
  p.updates = {bundle(0), bundle(1)};
  m.sent(2, 60, p, 300);  // a repeat and a new one, in the next second
  p.updates.clear();
  m.sent(2, 61, p, 70);
  const report::Traffic& t = m.total();
  EXPECT_EQ(t.updates[static_cast<std::size_t>(sync::Cause::kContactBegin)], 2U);
  EXPECT_EQ(t.updates[static_cast<std::size_t>(sync::Cause::kProxy)], 2U);
  EXPECT_EQ(t.all_updates(), 4U);
  EXPECT_EQ(t.repeats, 2U);
  EXPECT_EQ(t.datagrams, 5U);
  EXPECT_EQ(t.wire_bytes, 970U);
  ASSERT_EQ(m.per_second().size(), 2U);
  EXPECT_EQ(m.per_second()[0].datagrams, 3U);
  EXPECT_EQ(m.per_second()[1].all_updates(), 2U);
}

report::Survey incarnation(const std::string& name, Tick last) {
  report::Survey s;
  s.name = name;
  s.first_step = s.came = s.confirmed_from = 0;
  s.last_tick = last;
  return s;
}

TEST(ConfirmedTicks, CountsWhatAllWhoReachItHaveConfirmed) {
  const std::vector<report::Survey> incarnations{incarnation("0", 9), incarnation("1", 9), incarnation("2", 3)};
  report::ConfirmedTicks c(incarnations);
  for (Tick t = 0; t <= 5; ++t) c.add(0, t, 7);
  for (Tick t = 0; t <= 4; ++t) c.add(1, t, 7);
  for (Tick t = 0; t <= 2; ++t) c.add(2, t, 7);
  // Peer 2 ended at tick 3: ticks 0 to 2 by all three, tick 3 by two of three, tick 4 by both that reach it.
  EXPECT_EQ(c.compare().ticks, 4U);
  EXPECT_EQ(c.compare().mismatches, 0U);
  c.add(2, 3, 8);
  const report::ConfirmedCheck check = c.compare();
  EXPECT_EQ(check.mismatches, 1U);
  EXPECT_EQ(check.first_mismatch, 3);
  EXPECT_EQ(check.who, "peers 0 1 against peer 2");
}

TEST(ConfirmedTicks, WhoCameLaterIsAskedForWhatItBeganWith) {
  std::vector<report::Survey> incarnations{incarnation("0", 9), incarnation("1", 9)};
  incarnations[1].confirmed_from = 3;
  report::ConfirmedTicks c(incarnations);
  for (Tick t = 0; t <= 5; ++t) c.add(0, t, 7);
  for (Tick t = 3; t <= 4; ++t) c.add(1, t, 7);
  EXPECT_EQ(c.compare().ticks, 2U) << "3 and 4; tick 5 is missing, and 0 to 2 are one peer's alone";
}

TEST(ConfirmedTicks, WhatWasGivenUpIsNotHeldAgainstAnybody) {
  std::vector<report::Survey> incarnations{incarnation("0", 9), incarnation("1.1", 4), incarnation("1.2", 9)};
  incarnations[1].superseded = true;
  incarnations[2].confirmed_from = 4;
  report::ConfirmedTicks c(incarnations);
  for (Tick t = 0; t <= 5; ++t) c.add(0, t, 7);
  for (Tick t = 0; t <= 3; ++t) c.add(1, t, t < 2 ? 7 : 8);
  for (Tick t = 4; t <= 5; ++t) c.add(2, t, 7);
  const report::ConfirmedCheck check = c.compare();
  EXPECT_EQ(check.mismatches, 0U);
  EXPECT_EQ(check.ticks, 2U);
  EXPECT_EQ(check.given_up, 4U);
  EXPECT_EQ(check.given_up_unlike, 2U);
}

// Once, the report said that worlds differed where a peer had been stopped, declared gone, and ended by itself.
TEST(ConfirmedTicks, WhoWasDeclaredGoneWhileItWentOnIsNotHeldAgainstAnybody) {
  const std::vector<report::Survey> incarnations{incarnation("0", 9), incarnation("1", 9), incarnation("2", 9)};
  report::ConfirmedTicks c(incarnations);
  for (Tick t = 0; t <= 5; ++t)
    for (const std::size_t n : {0U, 1U, 2U}) c.add(n, t, n == 2 && t >= 3 ? 8 : 7);
  EXPECT_EQ(c.compare().mismatches, 3U);
  c.give_up(2, 0);
  c.give_up(2, 1);
  const report::ConfirmedCheck check = c.compare();
  EXPECT_EQ(check.mismatches, 0U);
  EXPECT_EQ(check.ticks, 6U);
  EXPECT_EQ(check.given_up, 6U);
  EXPECT_EQ(check.given_up_unlike, 3U);
}

// Once, nothing was compared when the one that was cut off declared all others gone.
TEST(ConfirmedTicks, WhoDeclaresAllOthersGoneDoesNotKeepThemFromBeingCompared) {
  const std::vector<report::Survey> incarnations{incarnation("0", 9), incarnation("1", 9), incarnation("2", 9)};
  report::ConfirmedTicks c(incarnations);
  for (Tick t = 0; t <= 5; ++t)
    for (const std::size_t n : {0U, 1U, 2U}) c.add(n, t, n == 0 && t >= 3 ? 8 : 7);
  c.give_up(0, 1);
  c.give_up(0, 2);
  c.give_up(1, 0);
  c.give_up(2, 0);
  EXPECT_EQ(c.compare().ticks, 6U);
  EXPECT_EQ(c.compare().mismatches, 0U);
  EXPECT_EQ(c.compare().given_up_unlike, 3U);
  c.add(1, 6, 7);
  c.add(2, 6, 9);
  EXPECT_EQ(c.compare().mismatches, 1U);
}

TEST(ConfirmedTicks, OfTwoPartsAsLargeTheFirstIsTheSession) {
  const std::vector<report::Survey> incarnations{incarnation("0", 9), incarnation("1", 9), incarnation("2", 9),
                                                 incarnation("3", 9)};
  report::ConfirmedTicks c(incarnations);
  for (Tick t = 0; t <= 5; ++t)
    for (const std::size_t n : {0U, 1U, 2U, 3U}) c.add(n, t, n % 2 == 0 && t >= 3 ? 8 : 7);
  for (const std::size_t n : {0U, 2U})
    for (const std::size_t m : {1U, 3U}) {
      c.give_up(n, m);
      c.give_up(m, n);
    }
  EXPECT_EQ(c.compare().ticks, 6U);
  EXPECT_EQ(c.compare().mismatches, 0U);
  EXPECT_EQ(c.compare().given_up_unlike, 6U);
}

TEST(Utf8, OnlyWellFormedSequencesPass) {
  const std::string bad = "\xEF\xBF\xBD";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", ""},
      {"plain", "plain"},
      {"J\xC3\xBCrgen \xE2\x82\xAC \xF0\x9F\x98\x80", "J\xC3\xBCrgen \xE2\x82\xAC \xF0\x9F\x98\x80"},
      {"J\xFCrgen", "J" + bad + "rgen"},
      {"\xC0\xAF", bad + bad},                      // overlong
      {"\xE0\x80\x80", bad + bad + bad},            // overlong
      {"\xED\xA0\x80", bad + bad + bad},            // surrogate
      {"\xF4\x90\x80\x80", bad + bad + bad + bad},  // beyond U+10FFFF
      {"end \xE2\x82", "end " + bad},
  };
  for (const auto& [in, out] : cases) EXPECT_EQ(shell::valid_utf8(in), out);
}

TEST(Fixed, IsTheSameInEveryLocale) {
  EXPECT_EQ(shell::fixed(1234.5, 2), "1234.50");
  EXPECT_EQ(shell::fixed(-0.004, 2), "-0.00");
  EXPECT_EQ(shell::fixed(0.1 + 0.2, 3), "0.300");
}

}  // namespace
}  // namespace padr
