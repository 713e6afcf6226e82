#include "common/monitor/sampler.h"

#include <gtest/gtest.h>

#include <map>

#include "common/monitor/codec.h"
#include "common/scenarios/scenarios.h"
#include "shell/input_text.h"
#include "shell/netem_text.h"
#include "tests/seed.h"
#include "tools/lab/simulation.h"

namespace padr {
namespace {

using monitor::Detail;
using monitor::EventKind;
using monitor::Sampler;

TEST(Sampler, FramesAreDueAtTheirRateAndOnTheSameTicksForAll) {
  for (int rate = 1; rate <= 60; ++rate) {
    const Sampler s(rate, Detail::kAll);
    int due = 0;
    for (Tick t = 1; t <= 600; ++t) due += s.due(t) ? 1 : 0;
    EXPECT_EQ(due, 10 * rate);
    EXPECT_FALSE(s.due(0));
  }
  const Sampler twenty(20, Detail::kAll);
  EXPECT_TRUE(twenty.due(3));
  EXPECT_FALSE(twenty.due(4));
  EXPECT_TRUE(twenty.due(2'000'000'001)) << "hundreds of days on";
}

/// Two peers in the arena, the first one looked at.
struct Watched {
  explicit Watched(const char* technique, Tick ticks, const char* netem = "delay 50ms") : sampler(20, Detail::kAll) {
    lab::SimulationConfig c;
    c.scene = scenarios::load_embedded("arena", 1);
    c.technique = technique_by_name(technique);
    c.netem = shell::parse_netem(netem);
    c.ticks = ticks;
    for (int p = 0; p < 2; ++p) {
      inputs.push_back(shell::make_input("wander", {c.scene, p, 1, {}}));
      c.inputs.push_back(inputs.back().get());
    }
    simulation = std::make_unique<lab::Simulation>(c);
    sampler.begin(simulation->replica(0), "plays");
    simulation->run([this](Tick) {
      sampler.observe(simulation->replica(0));
      for (monitor::Event& e : sampler.take_events()) events.push_back(std::move(e));
    });
  }
  const node::Replica& replica() const { return simulation->replica(0); }

  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::unique_ptr<lab::Simulation> simulation;
  Sampler sampler;
  std::vector<monitor::Event> events;
};

TEST(Sampler, AFrameIsWhatTheNodeSees) {
  const Watched w("full", 400);
  monitor::Frame f;
  w.sampler.frame(w.replica(), {1, 2}, f);
  const world::View& live = w.replica().live().world();
  ASSERT_EQ(f.total, live.entities());
  EXPECT_EQ(f.tick, 400);
  EXPECT_EQ(f.threshold, w.replica().threshold());
  EXPECT_EQ(f.target, (Vec2{1, 2}));
  for (EntityId e = 0; e < f.total; ++e) {
    EXPECT_EQ(f.live[e].position, live.position(e));
    EXPECT_EQ(f.shown[e].position, w.replica().shown().positions()[e]);
    EXPECT_EQ(f.predicted[e].position, w.replica().agreed().predicted_state().world.entities[e].position);
    EXPECT_EQ(f.flags[e].awake, live.awake(e));
    EXPECT_EQ(f.flags[e].present, live.present(e));
  }
  EXPECT_EQ(f.flags[live.avatar(1)].owner, 1);
  const Sampler modest(20, Detail::kShown);
  modest.frame(w.replica(), {}, f);
  EXPECT_TRUE(f.live.empty() && f.predicted.empty());
  const auto datagrams = monitor::encode({}, f);
  ASSERT_EQ(datagrams.size(), 1U);
  EXPECT_LT(datagrams[0].size(), 62 * 12 + 60U);
}

TEST(Sampler, ContactsAndAuthorityBeginAndEndInTurn) {
  for (const char* technique : {"full", "adaptive"}) {
    const Watched w(technique, 1200);
    std::map<EntityId, bool> held;
    std::map<EntityId, PeerId> owner;
    std::uint32_t number = 0;
    std::map<EventKind, int> seen;
    for (const monitor::Event& e : w.events) {
      EXPECT_EQ(e.number, ++number);
      ++seen[e.kind];
      if (e.kind == EventKind::kContactBegin || e.kind == EventKind::kContactEnd) {
        EXPECT_NE(held[e.entity], e.kind == EventKind::kContactBegin) << "body " << e.entity << " at " << e.tick;
        held[e.entity] = e.kind == EventKind::kContactBegin;
      } else if (e.kind == EventKind::kAuthority) {
        owner[e.entity] = e.peer;
      } else if (e.kind == EventKind::kRelease) {
        EXPECT_EQ(owner[e.entity], e.peer);
        owner[e.entity] = kNoPeer;
      }
    }
    EXPECT_EQ(seen[EventKind::kLife], 1);
    EXPECT_GT(seen[EventKind::kContactBegin], 5) << technique;
    EXPECT_GT(seen[EventKind::kContactEnd], 5);
    EXPECT_GT(seen[EventKind::kAuthority], 5);
    EXPECT_GT(seen[EventKind::kRelease], 1);
    EXPECT_EQ(seen[EventKind::kMismatch], 0);
    for (const auto& [b, is] : held) EXPECT_EQ(is, w.replica().reporter().holds(b));
    for (const auto& [b, is] : owner) EXPECT_EQ(is, w.replica().agreed().predicted_state().authority[b].holder());
  }
}

TEST(Sampler, AStatusIsWhatTheNodeCounts) {
  const Watched w("full", 600);
  const monitor::Status s = Sampler::status(w.replica());
  EXPECT_EQ(s.tick, 600);
  EXPECT_EQ(s.bytes_sent, w.replica().stats().wire_bytes_sent);
  EXPECT_EQ(s.hash, w.replica().agreed().confirmed_hash());
  EXPECT_GT(s.confirmed, 500);
  EXPECT_EQ(s.present, 2);
  ASSERT_EQ(s.links.size(), 1U);
  EXPECT_EQ(s.links[0].to, 1);
  EXPECT_TRUE(s.links[0].there && s.links[0].measured);
  EXPECT_NEAR(s.links[0].delay_least_ms, 50, 17);
  EXPECT_NEAR(s.links[0].round_trip_ms, 100, 5);
  EXPECT_EQ(s.links[0].loss_in, 0);
}

// At jitter the least is half of what most datagrams take.
TEST(Sampler, DelayIsTheMiddleAndTheSlowestTwentiethAndLossIsOfWhatWasSent) {
  const Watched w("avatar-only", 1200, "delay 100ms 50ms loss 10%");
  const monitor::Status s = Sampler::status(w.replica());
  ASSERT_EQ(s.links.size(), 1U);
  const monitor::LinkStatus& l = s.links[0];
  ASSERT_TRUE(l.measured);
  EXPECT_LT(l.delay_least_ms, 75);
  EXPECT_NEAR(l.delay_p50_ms, 108, 20) << "and half a tick until the step";
  EXPECT_GT(l.delay_p95_ms, 135);
  EXPECT_LT(l.delay_p95_ms, 175);
  const std::uint64_t sent = w.simulation->replica(1).stats().datagrams_sent;
  EXPECT_NEAR(static_cast<double>(l.judged_in), static_cast<double>(sent), 20) << "but for those under way";
  EXPECT_NEAR(static_cast<double>(l.lost_in) / static_cast<double>(l.judged_in), 0.1, 0.06);
  EXPECT_GT(l.loss_of, 0U);
  EXPECT_LE(l.loss_of, 192U);
}

TEST(Sampler, AnAgreedWorldIsTheConfirmedOneWithItsOwners) {
  const Watched w("full", 600);
  const sync::FoldState& c = w.replica().agreed().confirmed();
  monitor::Agreed a;
  Sampler::agreed(c, 99, true, a);
  EXPECT_EQ(a.tick, c.tick);
  EXPECT_EQ(a.hash, 99U);
  ASSERT_EQ(a.total, 62);
  for (EntityId e = 0; e < a.total; ++e) {
    EXPECT_EQ(a.at[e].position, c.world.entities[e].position);
    EXPECT_EQ(a.flags[e].owner, e < 60 ? c.authority[e].holder() : e - 60);
  }
}

TEST(Sampler, WhoComesAndGoesIsAnEvent) {
  Sampler s(20, Detail::kAll);
  using Kind = node::MemberChange::Kind;
  for (const Kind kind : {Kind::kAdmitted, Kind::kLeft, Kind::kRemoved}) {
    node::MemberChange c;
    c.kind = kind;
    c.slot = 4;
    c.tick = 77;
    s.observe(c);
  }
  const auto events = s.take_events();
  ASSERT_EQ(events.size(), 3U);
  EXPECT_EQ(events[0].kind, EventKind::kJoined);
  EXPECT_EQ(events[1].kind, EventKind::kLeft);
  EXPECT_EQ(events[2].kind, EventKind::kRemoved);
  EXPECT_EQ(events[2].peer, 4);
  EXPECT_EQ(events[2].tick, 77);
  EXPECT_TRUE(s.take_events().empty());
}

}  // namespace
}  // namespace padr
