#include <gtest/gtest.h>

#include "common/wire/codec.h"
#include "common/wire/session_codec.h"
#include "tools/capture/timeline.h"

namespace padr::capture {
namespace {

constexpr EntityId kBody = 12;

/// What peers tell of one body, in the order in which it is captured.
class Told {
 public:
  void claim(PeerId by, std::uint32_t index, Tick tick, std::uint32_t epoch, Tick claimed) {
    sync::StatePacket p;
    p.seq = ++seq_;
    p.mark_tick = 200;
    p.mark_count = 10;
    p.updates.resize(1);
    p.updates[0].index = index;
    p.updates[0].tick = tick;
    sync::BodyUpdate u;
    u.body = kBody;
    u.has_state = true;
    u.held = true;
    u.epoch = epoch;
    u.claimed = claimed;
    p.updates[0].bodies = {u};
    const wire::Bytes bytes = wire::seal({wire::Kind::kState, by, 77}, wire::encode(p));
    Datagram d;
    d.time_ns = std::int64_t{1000} * ++seq_;
    d.payload = bytes;
    timeline_.take(d);
  }

  /// "tick event peer" of the events about the body.
  std::vector<std::string> events() const {
    std::vector<std::string> all;
    const auto sessions = timeline_.events();
    for (const Event& e : sessions.at(77))
      if (e.entity == kBody)
        all.push_back(std::to_string(e.tick) + " " + std::string(e.what) + " " + std::to_string(e.by.slot));
    return all;
  }

 private:
  Timeline timeline_;
  std::uint32_t seq_ = 0;
};

/// "event detail" of what peer 1 tells in datagrams of these numbers, each with update 0.
std::vector<std::string> resends(const std::vector<std::uint32_t>& seqs) {
  Timeline timeline;
  std::vector<std::string> all;
  for (const std::uint32_t seq : seqs) {
    sync::StatePacket p;
    p.seq = seq;
    p.mark_tick = 200;
    p.mark_count = 1;
    p.updates.resize(1);
    p.updates[0].tick = 190;
    const wire::Bytes bytes = wire::seal({wire::Kind::kState, 1, 77}, wire::encode(p));
    Datagram d;
    d.payload = bytes;
    timeline.take(d);
  }
  const auto sessions = timeline.events();
  for (const Event& e : sessions.at(77))
    if (e.what == "resend" || e.what == "gap") all.push_back(std::string(e.what) + " " + e.detail);
  return all;
}

using Lines = std::vector<std::string>;

TEST(Timeline, AClaimStandsAtItsTickThoughALaterUpdateIsCapturedFirst) {
  Told told;
  told.claim(1, 6, 60, 1, 50);
  told.claim(1, 5, 50, 1, 50);
  EXPECT_EQ(told.events(), (Lines{"50 claim 1"}));
}

TEST(Timeline, AClaimCapturedAfterTheOneThatFollowedItIsNotLost) {
  Told told;
  told.claim(2, 1, 60, 2, 60);
  told.claim(1, 1, 50, 1, 50);
  EXPECT_EQ(told.events(), (Lines{"60 claim 2", "50 claim 1"}));
}

TEST(Timeline, OfTwoClaimsOfOneEpochTheLaterOneIsLost) {
  Told told;
  told.claim(2, 1, 52, 1, 52);
  told.claim(1, 1, 50, 1, 50);
  EXPECT_EQ(told.events(), (Lines{"52 claim_lost 2", "50 claim 1"}));
}

// As summary counts them. Once, what came late was left out.
TEST(Timeline, ResendsAreThoseOfLateDatagramsTooButNotOfDuplicates) {
  EXPECT_EQ(resends({1, 3, 2, 3}), (Lines{"gap 1", "resend update 0", "resend update 0"}));
}

// A Join knows no session; its answer has the nonce. Once, with two sessions in a capture there was no Join at all.
TEST(Timeline, AJoinIsOfTheSessionThatAnswersIt) {
  Timeline timeline;
  const auto take = [&](PeerId sender, std::uint16_t session, const wire::SessionMessage& m) {
    const wire::Bytes bytes = wire::seal({wire::Kind::kSession, sender, session}, wire::encode_session(m));
    Datagram d;
    d.payload = bytes;
    timeline.take(d);
  };
  for (const std::uint16_t session : std::initializer_list<std::uint16_t>{77, 78}) {
    wire::Join join;
    join.nonce = session;
    join.scenario = std::to_string(session);
    take(kNoPeer, 0, join);
    take(0, session,
         wire::Welcome{.nonce = session, .peer = 1, .slots = 2, .wanted = 2, .incarnation = 1, .cookie = 1});
  }
  const auto sessions = timeline.events();
  EXPECT_FALSE(sessions.contains(0));
  for (const std::uint16_t session : std::initializer_list<std::uint16_t>{77, 78}) {
    std::string joins;
    for (const Event& e : sessions.at(session)) joins += e.what == "join" ? e.detail : "";
    EXPECT_EQ(joins, std::to_string(session));
  }
}

}  // namespace
}  // namespace padr::capture
