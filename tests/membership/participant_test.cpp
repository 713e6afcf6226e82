// What a program of one's own gets of a participant that is given no more than it has to be.
#include "common/participant/participant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "common/scenarios/scenarios.h"
#include "common/trace/trace_reader.h"

namespace padr::node {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Endpoint place(std::uint16_t port) {
  return ipv4({127, 0, 0, 1}, port);
}

Scene arena(std::uint64_t seed) {
  return scenarios::load(scenarios::embedded_text("arena"), "arena", seed);
}

ParticipantConfig least(std::uint64_t seed, bool joins) {
  ParticipantConfig c;
  if (joins) c.session.join = place(1);
  c.session.seed = c.session.secret = seed;
  c.replica.technique = technique_by_name("full");
  return c;
}

/// Two of them, whose datagrams arrive at once.
class Two {
 public:
  Two(const Scene& a, const Scene& b) : Two(a, b, least(1, false), least(2, true)) {}
  Two(const Scene& a, const Scene& b, ParticipantConfig founder, ParticipantConfig joiner)
      : founder_(a, std::move(founder), 0), joiner_(b, std::move(joiner), 0) {}

  void run(Micros until) {
    for (; now_ < until; now_ += 1'000) {
      turn(founder_, joiner_, 1);
      turn(joiner_, founder_, 2);
    }
  }
  Participant& founder() { return founder_; }
  Participant& joiner() { return joiner_; }

  Vec2 target{10, 7};  ///< m, of both

 private:
  void turn(Participant& from, Participant& to, std::uint16_t port) {
    if (from.next_due() <= now_) from.advance(now_);
    while (from.step_due(now_)) from.step(target, now_);
    std::vector<wire::Bytes> sent;
    for (const Parcel& p : from.take_outgoing()) sent.emplace_back(p.bytes);
    for (const wire::Bytes& bytes : sent) to.receive(place(port), bytes, now_);
  }

  Micros now_ = 0;
  Participant founder_;
  Participant joiner_;
};

TEST(Participant, IsGivenNoMoreThanATechniqueAndSeedsAndPlays) {
  Two two(arena(1), arena(1));
  two.run(4 * kMicrosPerSecond);
  ASSERT_TRUE(two.founder().playing() && two.joiner().playing());
  EXPECT_GT(two.joiner().replica().stats().hash_checks, 0U);
  EXPECT_EQ(two.joiner().replica().stats().hash_mismatches, 0U);
}

TEST(Participant, OfAnotherSceneIsRefused) {
  Two two(arena(1), arena(2));
  two.run(2 * kMicrosPerSecond);
  ASSERT_TRUE(two.joiner().failed());
  EXPECT_NE(two.joiner().session().failure().find("scenario differs"), std::string::npos)
      << two.joiner().session().failure();
}

TEST(Participant, ASessionThatTheSceneHasNoRoomForIsAMistakeOfTheCallers) {
  const auto mistake = [](int wanted, int slots) -> std::string {
    ParticipantConfig c = least(1, false);
    c.session.wanted = wanted;
    c.session.slots = slots;
    try {
      Participant p(arena(1), c, 0);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  const std::string places = std::to_string(std::min<std::size_t>(arena(1).avatar.spawns.size(), kMaxPeers));
  EXPECT_EQ(mistake(2, 80), "slots: 80 is not allowed; give 1 to " + places + ", the scenario's places to start from");
  EXPECT_EQ(mistake(0, 2), "wanted: 0 is not allowed; give 1 to 2, the slots for players");
  EXPECT_EQ(mistake(3, 2), "wanted: 3 is not allowed; give 1 to 2, the slots for players");
  EXPECT_EQ(mistake(1, 1), "");
}

// The others would drop whatever tells of it, and in the end its sender.
TEST(Participant, GetsByWithTargetsThatNobodyBelieves) {
  Two two(arena(1), arena(1));
  two.run(4 * kMicrosPerSecond);
  Micros until = 4 * kMicrosPerSecond;
  for (const Vec2 odd : {Vec2{kNan, 7}, Vec2{20'000, 7}, Vec2{-1e30F, 1e30F}, Vec2{10, kNan}}) {
    two.target = odd;
    two.run(until += kMicrosPerSecond);
    for (const Participant* p : {&two.founder(), &two.joiner()}) {
      EXPECT_EQ(p->session().present(), 2);
      for (const std::uint64_t dropped : p->replica().stats().dropped) EXPECT_EQ(dropped, 0U);
    }
  }
  EXPECT_GT(two.founder().replica().stats().bundles, 0U);
}

TEST(Participant, AnOddTechniqueIsAMistakeOfTheCallers) {
  const auto mistake = [](const std::function<void(Technique&)>& spoil) -> std::string {
    ParticipantConfig c = least(1, false);
    c.session.wanted = 1;
    spoil(c.replica.technique);
    try {
      Participant(arena(1), c, 0).retune(c.replica.technique);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(mistake([](Technique&) {}), "");
  EXPECT_EQ(mistake([](Technique& t) { t.model = static_cast<Model>(9); }),
            "technique.model: 9 is not allowed; give 0 to 4");
  EXPECT_EQ(mistake([](Technique& t) { t.steps = -1; }), "technique.steps: -1 is not allowed; give 0 to 100000");
  EXPECT_NE(mistake([](Technique& t) { t.lead = kNan; }).find("technique.lead: nan is not allowed"), std::string::npos);
  EXPECT_NE(mistake([](Technique& t) { t.budget = -1; }).find("technique.budget"), std::string::npos);
  Participant p(arena(1), least(1, false), 0);
  EXPECT_THROW(p.retune(technique_by_name("avatar-only")), UserError) << "it has another rule of authority";
  p.retune(technique_by_name("fixed"));
}

TEST(Participant, RefusesAPushThatNoTraceCanHold) {
  Two two(arena(1), arena(1));
  two.run(4 * kMicrosPerSecond);
  Participant& p = two.joiner();
  for (const Vec2 odd : {Vec2{kNan, 5}, Vec2{1e30F, 5}, Vec2{0, -1'001}}) EXPECT_THROW(p.push(0, odd), UserError);
  EXPECT_THROW(p.push(static_cast<EntityId>(arena(1).bodies.size()), {1, 0}), UserError);
  p.push(0, {1'000, -1'000});
}

// All of docs/own-game.md in one.
TEST(Participant, PlaysWithAKeyBeforeASpectatorAndIsRecorded) {
  std::vector<std::byte> trace;
  const auto config = [](std::uint8_t n) {
    ParticipantConfig c = least(n, n > 1);
    ChannelConfig& channels = c.channels.emplace();
    channels.session.fill(7);
    channels.seed.fill(n);
    channels.random = [rng = std::make_shared<Rng>(n)](std::span<std::byte> out) {
      for (std::byte& b : out) b = static_cast<std::byte>(rng->below(256));
    };
    channels.mode = wire::SealMode::kEncrypt;
    return c;
  };
  ParticipantConfig founder = config(1);
  founder.session.wanted = 1;
  founder.recording = [&trace](int) {
    RecordedReplica::Recording to;
    to.provenance.scenario = "arena";
    to.provenance.scenario_text = scenarios::embedded_text("arena");
    to.provenance.scenario_seed = 1;
    to.sink = [&trace](std::span<const std::byte> b) { trace.insert(trace.end(), b.begin(), b.end()); };
    return std::optional(to);
  };
  ParticipantConfig spectator = config(2);
  spectator.session.spectates = true;
  Two two(arena(1), arena(1), std::move(founder), std::move(spectator));
  two.run(4 * kMicrosPerSecond);
  ASSERT_TRUE(two.founder().playing() && two.joiner().playing());
  EXPECT_TRUE(two.joiner().replica().playing()) << "the spectator is not waited for";
  EXPECT_EQ(two.founder().session().players(), 1);
  EXPECT_EQ(two.founder().session().spectators(), 1);
  EXPECT_GT(two.joiner().replica().stats().hash_checks, 0U);
  two.founder().finish();
  trace::TraceReader reader(trace, "own_game.trace");
  int steps = 0;
  while (const auto event = reader.next()) steps += std::holds_alternative<trace::Step>(*event) ? 1 : 0;
  EXPECT_GT(steps, 200);
  EXPECT_TRUE(reader.clean());
}

TEST(Participant, IsDoneAtOnceIfItLeavesBeforeItIsIn) {
  Participant p(arena(1), least(1, true), 0);
  p.advance(kMicrosPerSecond);
  ASSERT_FALSE(p.playing());
  EXPECT_FALSE(p.done(kMicrosPerSecond));
  p.leave(kMicrosPerSecond);
  EXPECT_TRUE(p.done(kMicrosPerSecond));
}

TEST(Participant, HasNoWorldBeforeItPlays) {
  Participant p(arena(1), least(1, true), 0);
  ASSERT_FALSE(p.playing());
  EXPECT_FALSE(p.step_due(kMicrosPerSecond));
  EXPECT_DEATH(p.replica(), "playing");
  EXPECT_DEATH(p.recorded(), "playing");
  EXPECT_DEATH(p.next_step(), "playing");
  EXPECT_DEATH(p.step({}, 0), "playing");
  EXPECT_DEATH(p.push(0, {}), "playing");
  EXPECT_DEATH(p.coordinator(), "playing");
  EXPECT_DEATH(p.place(0), "playing");
}

// What is drawn before the first step must not be a heap in the corner.
TEST(Participant, ShowsTheSceneFromTheFirstMomentOn) {
  const Scene scene = arena(1);
  ParticipantConfig c = least(1, false);
  c.session.wanted = 1;
  Participant p(scene, c, 0);
  Micros now = 0;
  while (!p.playing() && now < kMicrosPerSecond * 10) p.advance(now += 1'000);
  ASSERT_TRUE(p.playing());
  const std::vector<Vec2>& shown = p.replica().shown().positions();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    EXPECT_LT(distance(shown[b], p.replica().live().world().position(static_cast<EntityId>(b))), 1e-6F) << b;
}

}  // namespace
}  // namespace padr::node
