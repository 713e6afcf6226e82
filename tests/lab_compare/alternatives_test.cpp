#include <gtest/gtest.h>

#include <memory>

#include "common/scenarios/scenarios.h"
#include "common/wire/seal.h"
#include "shell/netem_text.h"
#include "shell/scenario_flags.h"
#include "tests/lab_compare/ending.h"
#include "tools/lab/alternatives/alternative_run.h"
#include "tools/lab/compare/contestant.h"

namespace padr::lab::alternatives {
namespace {

constexpr Tick kPlayed = 10 * kTicksPerSecond;
constexpr Tick kSettled = 9 * kTicksPerSecond;  // more than DIS's heartbeat, and rest

/// A session that is played and then left alone.
struct Played {
  Played(const Spec& spec, const std::string& netem, const std::string& scenario = "arena", int peers = 3) {
    SessionConfig config;
    config.scene = scenarios::load_embedded(scenario, 3);
    config.peers = peers;
    config.spec = spec;
    config.netem = shell::parse_netem(netem, nullptr);
    config.netem_seed = 3;
    for (PeerId p = 0; p < peers; ++p) {
      inputs.push_back(std::make_unique<Ending>(shell::load_input("wander", config.scene, p, 3), kPlayed));
      config.inputs.push_back(inputs.back().get());
    }
    bodies = static_cast<EntityId>(config.scene.bodies.size());
    session = std::make_unique<AlternativeRun>(std::move(config));
    for (EntityId b = 0; b < bodies; ++b) begun.push_back(session->peer(0).world().position(b));
  }
  void run(Tick ticks) const {
    for (Tick t = 0; t < ticks; ++t) session->step();
  }
  int touched() const {
    int n = 0;
    if (session->owner(0) == kNoPeer) {  // no authority: by where they are
      const world::World& w = session->peer(0).world();
      for (EntityId b = 0; b < bodies; ++b) n += distance(w.position(b), begun[b]) > 0.01F ? 1 : 0;
      return n;
    }
    for (EntityId b = 0; b < bodies; ++b) n += session->peer(session->owner(b)).claim(b).sequence > 0 ? 1 : 0;
    return n;
  }
  void expect_agreed(const std::string& who, int peers = 3) const {
    for (EntityId b = 0; b < bodies; ++b)
      for (PeerId p = 0; p < peers; ++p)
        EXPECT_EQ(session->peer(p).claim(b).owner, session->owner(b)) << who << ", body " << b << ", peer " << int{p};
  }
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::unique_ptr<AlternativeRun> session;
  EntityId bodies = 0;
  std::vector<Vec2> begun;  ///< m, by body
};

/// m, of all entities together, when everything is at rest: what rounding leaves.
double rounding(const Spec& spec) {
  constexpr double kEntities = 63;
  return spec.steps_per_m == kFinestPlace ? 0.06 : kEntities * 0.75 / spec.steps_per_m;
}

std::vector<std::pair<std::string, Spec>> every_alternative() {
  std::vector<std::pair<std::string, Spec>> all;
  for (const compare::Contestant& c : compare::all_contestants()) {
    // Further points of a curve are the same code, but for coarser places.
    const bool other_code = c.group != compare::Group::kFrontier || c.id.ends_with("-coarse");
    if (const auto* spec = std::get_if<Spec>(&c.how); spec != nullptr && other_code) all.emplace_back(c.id, *spec);
  }
  return all;
}

TEST(Alternatives, DeliverAndConvergeOnACleanLink) {
  for (const auto& [id, spec] : every_alternative()) {
    const Played play(spec, "");
    play.run(kPlayed);
    EXPECT_GT(play.touched(), 5) << id << ": the test is to move something";
    EXPECT_LT(play.session->meter().overall().mean_m, spec.kind == Kind::kStateSync ? 0.3 : 2.5) << id;
    if (spec.kind == Kind::kSnapshot) {
      EXPECT_LT(play.session->delayed_mean_m(), 0.1) << id;
    }
    play.run(kSettled);
    EXPECT_LT(play.session->meter().overall().final_m, rounding(spec)) << id;
    play.expect_agreed(id);
  }
}

TEST(Alternatives, SurviveABadLink) {
  const std::string bad = "delay 80ms 40ms loss 20% duplicate 10% reorder 10% corrupt 2%";
  for (const auto& [id, spec] : every_alternative()) {
    const Played play(spec, bad);
    play.run(kPlayed);
    EXPECT_LT(play.session->meter().overall().mean_m, 8) << id;
    for (PeerId p = 0; p < 3; ++p) EXPECT_GT(play.session->peer(p).stats().datagrams_dropped, 0U) << id;
    // DIS has nothing but heartbeats to mend losses: a fifth of them is lost too.
    play.run(spec.kind == Kind::kDis ? 3 * kSettled : kSettled);
    EXPECT_LT(play.session->meter().overall().final_m, spec.kind == Kind::kDis ? 0.5 : rounding(spec)) << id;
    play.expect_agreed(id);
  }
}

TEST(Alternatives, KeepToTheirBytes) {
  for (const auto& [id, spec] : every_alternative()) {
    const Played play(spec, "delay 100ms loss 5%", "clutter", 4);
    play.run(kPlayed / 2);
    for (PeerId p = 0; p < 4; ++p) {
      const AlternativeStats& s = play.session->peer(p).stats();
      EXPECT_LE(s.largest, wire::kMaxDatagram) << id;
      if (spec.kind == Kind::kDis) continue;
      EXPECT_LE(s.datagrams_sent, static_cast<std::uint64_t>(3 * spec.hz * play.session->now() / kTicksPerSecond))
          << id;
      if (spec.kind != Kind::kStateSync) continue;
      const std::size_t budget = std::size_t{8000} / static_cast<std::size_t>(spec.hz);
      EXPECT_LE(s.largest, budget + wire::kHeaderBytes + wire::kTagBytes) << id;
    }
  }
}

TEST(Alternatives, QuietWhenNothingMoves) {
  for (const auto& [id, spec] : every_alternative()) {
    if (spec.kind == Kind::kInputs) continue;  // an input that stays the same is one that the others wait for
    const Played play(spec, "delay 50ms");
    play.run(kPlayed + kSettled);
    const std::uint64_t before = play.session->peer(1).stats().datagrams_sent;
    play.run(5 * kTicksPerSecond);
    // Twice a second to each of two others, or DIS's heartbeats, which need not fall into one tick.
    EXPECT_LE(play.session->peer(1).stats().datagrams_sent - before, spec.kind == Kind::kDis ? 100U : 30U) << id;
  }
}

}  // namespace
}  // namespace padr::lab::alternatives
