#include "tools/monitor/observed_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/model/rng.h"
#include "tests/monitor_server/watched_session.h"
#include "tests/seed.h"
#include "tools/monitor/film.h"
#include "tools/monitor/prometheus.h"
#include "tools/monitor/words.h"

namespace padr::monitor {
namespace {

using nlohmann::json;

/// Everything goes through the codec, and some of it is lost, comes twice or late.
struct Heard {
  Heard(int peers, Tick ticks, double loss)
      : rng(test::seed()),
        told(peers, ticks, test::seed()),
        session({7, scene_hash(told.scene)}, told.scene, "arena", 1, peers, 0) {
    told.run(
        [&](const Origin& from, const Message& m) {
          for (const Bytes& b : encode(from, m)) {
            const bool hello = std::holds_alternative<Hello>(m);
            if (!hello && rng.chance(loss)) continue;
            pending.push_back(b);
            if (rng.chance(loss)) pending.push_back(b);
          }
          if (rng.chance(1 - loss)) deliver();
        },
        [&](Tick t) {
          deliver();
          now = tick_start(t);
          if (t % 15 == 0) session.sample(now);
        });
  }
  void deliver() {
    for (const Bytes& b : pending) {
      const auto t = decode_told(b);
      ASSERT_TRUE(t);
      session.take(*t, {}, now);
    }
    pending.clear();
  }

  Rng rng;
  test::WatchedSession told;
  ObservedSession session;
  std::vector<Bytes> pending;
  Micros now = 0;
};

TEST(ObservedSession, PutsTogetherWhatPeersTell) {
  Heard h(3, 900, 0);
  EXPECT_EQ(h.session.peers().size(), 3U);
  EXPECT_EQ(h.session.tick(), 900);
  EXPECT_EQ(h.session.agreement().all(), Agreement::Verdict::kIdentical);
  EXPECT_GT(h.session.agreement().compared(), 400U);
  for (PeerId p = 0; p < 3; ++p) {
    EXPECT_EQ(h.session.peer(p)->lost, 0U);
    EXPECT_EQ(h.session.peer(p)->frames, 300U);
    EXPECT_TRUE(h.session.inconsistency(p));
    ASSERT_TRUE(h.session.peer(p)->rates.rates());
    EXPECT_GT(h.session.peer(p)->rates.rates()->kbit_per_s, 0.5);
    EXPECT_GT(*h.session.peer(p)->lag_ms(), 50);
  }
  EXPECT_EQ(h.session.series().points().size(), 60U);
  EXPECT_FALSE(h.session.events().empty());
}

TEST(ObservedSession, LossDoublesAndReorderingAreBorne) {
  Heard h(3, 900, 0.05);
  EXPECT_EQ(h.session.agreement().all(), Agreement::Verdict::kIdentical);
  for (PeerId p = 0; p < 3; ++p) {
    EXPECT_GT(h.session.peer(p)->frames, 200U);
    EXPECT_GT(h.session.peer(p)->lost, 0U);
    EXPECT_LE(h.session.peer(p)->frames + h.session.peer(p)->lost, 301U);
    EXPECT_TRUE(h.session.inconsistency(p)) << "of the ticks that came";
  }
}

TEST(ObservedSession, ViewsAreOfTheNewestTickAndHaveTheBytesPromised) {
  Heard h(2, 300, 0);
  const auto all = h.session.views(31, 0);
  EXPECT_EQ(all.size(), 2U * 4U + 1U) << "four of each peer, and the authority's";
  const std::size_t entities = h.told.scene.bodies.size() + 2;
  for (const auto& v : all) {
    const std::string& b = *v.bytes;
    ASSERT_EQ(b.size(), 24 + 16 * entities);
    EXPECT_EQ(b[0], 1);
    const auto u8 = [&b](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(b[i])); };
    const unsigned tick = u8(4) | u8(5) << 8U | u8(6) << 16U | u8(7) << 24U;
    EXPECT_TRUE(b[2] == 3 || tick == 300U) << "confirmed trails";
    EXPECT_TRUE(b[2] != 4 || u8(1) == 255U);
    EXPECT_EQ(u8(20) | u8(21) << 8U, entities);
    EXPECT_EQ(u8(24) | u8(25) << 8U, 0U) << "the first body";
  }
  EXPECT_TRUE(h.session.views(31, h.session.serial()).empty());
  EXPECT_EQ(h.session.views(1, 0).size(), 2U);
}

TEST(ObservedSession, ANewLifeInASlotReplacesTheOld) {
  Heard h(2, 300, 0);
  const Origin again{999, 7, 1, 3};
  h.session.take({again, h.told.hello()}, {}, h.now);
  EXPECT_EQ(h.session.peer(1)->origin.process, 999U);
  EXPECT_EQ(h.session.peers().size(), 2U);
  h.session.take({test::WatchedSession::origin(1), h.told.hello()}, {}, h.now);
  EXPECT_EQ(h.session.peer(1)->origin.process, 999U) << "the older incarnation does not get it back";
}

TEST(ObservedSession, PeersThatHaveEvictedEachOtherMayConfirmDifferentWorlds) {
  Heard h(2, 300, 0);
  const auto confirms = [&h](PeerId p, bool other_is_there, std::uint64_t hash) {
    Status s;
    s.tick = 700;
    s.steps = 700;
    s.confirmed = 600;
    s.hash = hash;
    LinkStatus& l = s.links.emplace_back();
    l.to = 1 - p;
    l.there = other_is_there;
    h.session.take({test::WatchedSession::origin(p), s}, {}, h.now);
  };
  ASSERT_TRUE(h.session.sample(h.now).peers[1].inconsistency);
  confirms(0, true, 1);
  confirms(1, false, 2);
  EXPECT_FALSE(h.session.sample(h.now).peers[1].inconsistency) << "its own world says nothing of its error";
  EXPECT_FALSE(h.session.inconsistency(1));
  EXPECT_EQ(h.session.agreement().all(), Agreement::Verdict::kApart) << "it is enough that one has evicted the other";
  confirms(1, true, 2);
  EXPECT_EQ(h.session.agreement().all(), Agreement::Verdict::kDiffers);
  confirms(1, true, 1);
  EXPECT_EQ(h.session.agreement().all(), Agreement::Verdict::kIdentical);
  EXPECT_EQ(h.session.agreement().first_difference(), 600);
}

TEST(ObservedSession, WhoFallsSilentIsGoneAndThenForgotten) {
  Heard h(2, 300, 0);
  using Presence = PeerRecord::Presence;
  const Micros end = h.now;
  EXPECT_EQ(h.session.peer(1)->presence(end), Presence::kHere);
  EXPECT_EQ(h.session.peer(1)->presence(end + 2 * kMicrosPerSecond), Presence::kSilent);
  const Micros later = end + 10 * kMicrosPerSecond;
  h.session.take({test::WatchedSession::origin(0), h.told.hello()}, {}, later);
  h.session.advance(later);
  EXPECT_EQ(h.session.peer(1)->presence(later), Presence::kGone);
  EXPECT_EQ(h.session.peers().size(), 2U) << "still in the table";
  EXPECT_TRUE(h.session.alive(later));
  h.session.advance(end + 2 * ObservedSession::kForgetAfter);
  EXPECT_TRUE(h.session.peers().empty());
}

// Once, a peer that had said that it ends was silent for five seconds: what it told last was who it is.
TEST(ObservedSession, WhoSaysThatItEndsIsGoneAtOnce) {
  Heard h(2, 300, 0);
  const Origin one = test::WatchedSession::origin(1);
  ASSERT_TRUE(h.session.peer(1)->current_rates(h.now));
  h.session.take({one, Events{{{1'000'000, 300, EventKind::kEnd, kNoEntity, 1, 0, "stopped"}}}}, {}, h.now);
  h.session.take({one, h.told.hello()}, {}, h.now);
  EXPECT_EQ(h.session.peer(1)->presence(h.now), PeerRecord::Presence::kGone);
  EXPECT_FALSE(h.session.peer(1)->current_rates(h.now));
  // The same process in another life.
  h.session.take({{one.process, one.session, 1, 5}, h.told.hello()}, {}, h.now);
  EXPECT_EQ(h.session.peer(1)->presence(h.now), PeerRecord::Presence::kHere);
}

// Once, who stood still or was gone had the rates of before.
TEST(ObservedSession, RatesAreOfWhoPlays) {
  Heard h(2, 300, 0);
  EXPECT_TRUE(h.session.sample(h.now).peers.at(0).updates_per_s);
  EXPECT_FALSE(h.session.peer(0)->current_rates(h.now + 2 * kMicrosPerSecond)) << "silent";
  Status paused = *h.session.peer(0)->status;
  paused.paused = true;
  h.session.take({test::WatchedSession::origin(0), paused}, {}, h.now);
  EXPECT_FALSE(h.session.peer(0)->current_rates(h.now));
  EXPECT_FALSE(h.session.sample(h.now).peers.at(0).updates_per_s);
  EXPECT_TRUE(h.session.sample(h.now).peers.at(1).updates_per_s);
}

TEST(ObservedSession, ProcessesAreBounded) {
  Heard h(2, 30, 0);
  for (std::uint64_t process = 1000; process < 5000; ++process)
    h.session.take({{process, 7, kNoPeer, 0}, h.told.hello()}, {}, h.now);
  EXPECT_EQ(h.session.process(4999), nullptr);
  EXPECT_EQ(h.session.peers().size(), 2U);
}

TEST(ObservedSession, WordsAreJsonOfThePromisedShape) {
  Heard h(2, 600, 0);
  const json peers = json::parse(peers_text(
      h.session, 1, [](PeerId p) { return p == 0 ? "you" : "no"; }, h.now));
  EXPECT_EQ(peers["type"], "peers");
  EXPECT_EQ(peers["session"], 7);
  EXPECT_EQ(peers["other_sessions"], 1);
  EXPECT_EQ(peers["agreement"]["state"], "identical");
  ASSERT_EQ(peers["peers"].size(), 2U);
  const json& p = peers["peers"][0];
  EXPECT_EQ(p["driven"], "you");
  EXPECT_EQ(p["technique"], "full");
  EXPECT_EQ(p["knobs"]["threshold"], "0.014:0.012");
  EXPECT_EQ(p["confirmed"]["state"], "identical");
  EXPECT_EQ(p["links"][0]["to"], 1);
  EXPECT_EQ(p["rates"]["updates_per_s"].size(), sync::kCauses);
  const json scene = json::parse(scene_text(h.session));
  EXPECT_EQ(scene["bodies"].size(), h.told.scene.bodies.size());
  EXPECT_EQ(scene["slots"], 2);
  const json history = json::parse(history_text(h.session.series().points()));
  EXPECT_EQ(history["points"].size(), 40U);
  EXPECT_EQ(history["points"][39]["tick"], 600);
  EXPECT_TRUE(history["points"][39]["peers"][0]["combined_m"].is_number());
  const json events =
      json::parse(events_text(std::vector<SessionEvent>(h.session.events().begin(), h.session.events().end())));
  EXPECT_EQ(events["events"][0]["kind"], "life");
  const json hello = json::parse(hello_text({}));
  EXPECT_EQ(hello["knobs"][0]["name"], "threshold");
}

TEST(ObservedSession, FrequentEventsLeaveRoomForTheOthers) {
  Heard h(2, 30, 0);
  const auto count = [](const auto& events, EventKind kind) {
    return std::count_if(events.begin(), events.end(), [kind](const SessionEvent& e) { return e.event.kind == kind; });
  };
  Origin somebody = test::WatchedSession::origin(0);
  somebody.process = 999;
  std::uint32_t number = 0;
  const auto say = [&](EventKind kind) {
    h.session.take({somebody, Events{{Event{++number, 30, kind, kNoEntity, kNoPeer, 0, ""}}}}, {}, h.now);
  };
  say(EventKind::kCut);
  const auto before = h.session.events_ever();
  for (std::size_t i = 0; i < ObservedSession::kEvents + 10; ++i) say(EventKind::kAuthority);
  EXPECT_EQ(h.session.events_ever() - before, ObservedSession::kEvents + 10);
  EXPECT_EQ(count(h.session.events(), EventKind::kAuthority), ObservedSession::kEvents);
  EXPECT_EQ(count(h.session.events(), EventKind::kCut), 1);
  const auto newest = h.session.newest_events(500);
  EXPECT_EQ(count(newest, EventKind::kAuthority), 500);
  EXPECT_EQ(count(newest, EventKind::kCut), 1);
  EXPECT_EQ(newest.back().event.number, number);
}

TEST(ObservedSession, TextsOfPeersCannotBreakAMessage) {
  Heard h(2, 30, 0);
  Hello hello = h.told.hello();
  hello.technique = "a\"b\\ --threshold \xff<script> --x";
  hello.version = std::string("\x01\n\xc3", 3);
  h.session.take({test::WatchedSession::origin(0), hello}, {}, h.now);
  const json peers = json::parse(peers_text(
      h.session, 0, [](PeerId) { return "no"; }, h.now));
  EXPECT_EQ(peers["peers"][0]["technique"], "a\"b\\");
}

TEST(ObservedSession, MetricsAreInPrometheusForm) {
  Heard h(2, 600, 0);
  const std::string text = metrics_text(&h.session, {}, nullptr, h.now);
  EXPECT_NE(text.find("\npadr_peer_up{peer=\"0\",incarnation=\"0\"} 1\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\npadr_peer_agrees{peer=\"1\"} 1\n"), std::string::npos);
  EXPECT_NE(text.find("\npadr_peer_inconsistency_metres{peer=\"0\",part=\"avatars\"} "), std::string::npos);
  EXPECT_NE(text.find("\npadr_peer_updates_total{peer=\"0\",cause=\"threshold\"} "), std::string::npos);
  for (const char* what : {"delay", "delay_p95", "delay_least"})
    EXPECT_NE(text.find("\npadr_link_" + std::string(what) + "_seconds{from=\"1\",peer=\"0\"} 0."), std::string::npos)
        << what;
  EXPECT_NE(text.find("\n# TYPE padr_link_judged_total counter\n"), std::string::npos);
  EXPECT_NE(text.find("\npadr_link_lost_total{from=\"1\",peer=\"0\"} "), std::string::npos);
}

TEST(ObservedSession, WhatIsDroppedOfWhomAndWhoIsCutOffIsInTheWordsAndTheMetrics) {
  Heard h(3, 30, 0);
  Status told;
  told.tick = 31;
  for (const PeerId from : {PeerId{1}, PeerId{2}}) {
    LinkStatus l;
    l.to = from;
    l.there = from == 1;  // who was cut off is removed soon
    l.dropped[static_cast<std::size_t>(sync::DropReason::kDuplicate)] = 7;
    if (from == 2) l.dropped[static_cast<std::size_t>(sync::DropReason::kMalformed)] = 20;
    if (from == 2) l.cut_offs = 1;
    told.links.push_back(l);
  }
  for (const Bytes& b : encode(test::WatchedSession::origin(0), told)) {
    const auto t = decode_told(b);
    ASSERT_TRUE(t);
    h.session.take(*t, {}, h.now);
  }
  const json peers = json::parse(peers_text(
      h.session, 0, [](PeerId) { return "no"; }, h.now));
  const json expected = {{{"from", 1}, {"cut_off", 0}, {"by_reason", {{"duplicate", 7}}}},
                         {{"from", 2}, {"cut_off", 1}, {"by_reason", {{"malformed", 20}, {"duplicate", 7}}}}};
  EXPECT_EQ(peers["peers"][0]["drops"], expected);
  EXPECT_EQ(peers["peers"][1]["drops"], json::array());
  const std::string text = metrics_text(&h.session, {}, nullptr, h.now);
  EXPECT_NE(text.find("\npadr_peer_dropped_total{peer=\"0\",from=\"2\",reason=\"malformed\"} 20\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("\npadr_peer_dropped_total{peer=\"0\",from=\"1\",reason=\"duplicate\"} 7\n"), std::string::npos);
  EXPECT_NE(text.find("\npadr_peer_cut_offs_total{peer=\"0\",from=\"2\"} 1\n"), std::string::npos);
  EXPECT_EQ(text.find("padr_peer_cut_offs_total{peer=\"0\",from=\"1\""), std::string::npos);
}

TEST(Series, AnHourIsFlat) {
  Series s;
  for (Tick t = 0; t < 3 * 3600 * kTicksPerSecond; t += 15) s.add({t, {}});
  EXPECT_LT(s.points().size(), 3000U);
  const Tick newest = s.points().back().tick;
  EXPECT_GT(newest - s.points().front().tick, 59 * 60 * kTicksPerSecond);
  EXPECT_EQ(newest - s.points()[s.points().size() - 2].tick, 15) << "the last minutes are whole";
}

TEST(Film, SamplesDivideASecondAndKeepViewsBounded) {
  EXPECT_EQ(sample_for(20 * kTicksPerSecond, 17, 64), 1);
  for (const Tick ticks : {1000, 100'000, 1'000'000, 10'000'000}) {
    const Tick s = sample_for(ticks, 49, 222);
    EXPECT_EQ(kTicksPerSecond % s, 0);
  }
  EXPECT_EQ(sample_for(100'000'000, 49, 222), 60);
}

TEST(Film, AScreenGoesForwardsAndBack) {
  Film film;
  const auto picture = [](Tick t) {
    return Film::Picture{0, Which::kShown, std::make_shared<const std::string>(std::to_string(t))};
  };
  for (Tick t = 0; t <= 600; t += 3) film.moments.push_back({t, {picture(t)}});
  for (Tick t = 0; t <= 600; t += 15) film.tables.push_back({t, std::to_string(t), {}});
  Screen screen(film);
  screen.go_to(100);
  const auto first = screen.views(1, 0);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(*first[0].bytes, "99");
  EXPECT_EQ(screen.table()->tick, 90);
  EXPECT_TRUE(screen.views(1, screen.serial()).empty());
  const std::uint64_t seen = screen.serial();
  screen.go_to(31);
  ASSERT_EQ(screen.views(1, seen).size(), 1U) << "what is older is new to the page";
  EXPECT_EQ(*screen.views(1, seen)[0].bytes, "30");
  EXPECT_EQ(screen.table()->tick, 30);
  screen.go_to(600);
  EXPECT_EQ(*screen.views(1, 0)[0].bytes, "600");
  EXPECT_TRUE(screen.views(2, 0).empty());
}

}  // namespace
}  // namespace padr::monitor
