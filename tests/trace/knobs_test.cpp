// Knobs that change, and bodies that are pushed, while peers play: what it does to them, and that traces have it.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/model/user_error.h"
#include "common/trace/trace_reader.h"
#include "shell/technique_text.h"
#include "tests/seed.h"
#include "tests/trace/recorded_run.h"
#include "tools/lab/replay.h"

namespace padr {
namespace {

using shell::technique_of;
using test::RecordedRun;
using test::RunConfig;
using Nodes = std::vector<std::unique_ptr<node::RecordedReplica>>;

std::string difference(const std::vector<std::byte>& bytes) {
  trace::TraceReader reader(bytes, "some.trace");
  return lab::replay(reader).difference;
}

void expect_agreement(const RecordedRun& run) {
  // There is a hash every 30 ticks, and it is told once: the shortest run, of 130 ticks, has time for three.
  for (const auto& n : run.nodes) {
    EXPECT_GE(n->replica().stats().hash_checks, 3U);
    EXPECT_EQ(n->replica().stats().hash_mismatches, 0U);
  }
}

void expect_replays(const RecordedRun& run) {
  for (const auto& t : run.traces) EXPECT_EQ(difference(t), "");
}

TEST(Knobs, EveryKnobChangesWhilePlayingAndReplaysToTheBit) {
  const std::vector<Technique> settings{
      technique_of("full --replay off"),         technique_of("full --convergence blend"),
      technique_of("adaptive --replay off"),     technique_of("full --predictor pcc"),
      technique_of("full --threshold 0.05"),     technique_of("full --precision exact"),
      technique_of("full --model second"),       technique_of("full --unowned live"),
      technique_of("adaptive --unowned agreed"), technique_of("adaptive --time-stamps on"),
      technique_of("fixed --convergence snap"),  technique_by_name("everything"),
      technique_of("full --convergence blend"),  technique_by_name("full"),
  };
  RunConfig c;
  c.seed = test::seed(7);
  c.peers = 3;
  c.ticks = 900;
  c.netem = "delay 60ms 40ms loss 15% duplicate 3%";
  Rng rng(c.seed);
  std::size_t changes = 0;
  c.before_step = [&](Tick t, const Nodes& nodes) {
    if (t % 20 != 0 || t > 800) return;
    nodes[rng.below(3)]->retune(settings[changes++ % settings.size()]);
  };
  const RecordedRun run(c);
  EXPECT_GT(changes, 30U);
  expect_agreement(run);
  expect_replays(run);
}

// Whoever switches replay off and on again believes what those believe who never did.
TEST(Knobs, ReplayCanBeSwitchedOffAndOn) {
  RunConfig c;
  c.netem = "delay 100ms 20ms";
  c.ticks = 360;
  c.before_step = [](Tick t, const Nodes& nodes) {
    if (t == 120) nodes[1]->retune(technique_of("full --replay off"));
    if (t == 200) nodes[1]->retune(technique_by_name("full"));
  };
  const RecordedRun run(c);
  expect_agreement(run);
  expect_replays(run);
  const node::Replica& a = run.nodes[0]->replica();
  const node::Replica& b = run.nodes[1]->replica();
  const Tick both = std::min(a.agreed().confirmed().tick, b.agreed().confirmed().tick);
  EXPECT_GT(both, 300);
  ASSERT_NE(a.agreed().confirmed_at(both), nullptr);
  ASSERT_NE(b.agreed().confirmed_at(both), nullptr);
  EXPECT_EQ(sync::hash_of(*a.agreed().confirmed_at(both)), sync::hash_of(*b.agreed().confirmed_at(both)));
}

TEST(Knobs, ALowerThresholdTellsMoreFromThenOn) {
  const auto told = [](const char* threshold) {
    RunConfig c;
    c.technique = technique_by_name("fixed");
    c.ticks = 600;
    c.before_step = [threshold](Tick t, const Nodes& nodes) {
      if (t == 300) nodes[0]->retune(technique_of(std::string("fixed --threshold ") + threshold));
    };
    const RecordedRun run(c);
    return run.nodes[0]->replica().stats().updates_by_cause[static_cast<std::size_t>(sync::Cause::kThreshold)];
  };
  const auto coarse = told("0.5");
  const auto fine = told("0.05");
  EXPECT_GT(fine, 2 * coarse) << coarse;
}

/// The first body that nobody owns and nothing touches.
EntityId lonely_body(const node::Replica& n) {
  for (EntityId b = 0; b < n.live().world().bodies(); ++b) {
    const auto touches = [b](const Contact& c) { return c.first == b || c.second == b; };
    const auto& contacts = n.live().touching();
    const bool free = n.agreed().predicted_state().authority[b].holder() == kNoPeer;
    if (free && std::none_of(contacts.begin(), contacts.end(), touches)) return b;
  }
  return kNoEntity;
}

TEST(Pushes, APushedBodyIsThePushersAndGoesThereForEverybody) {
  RunConfig c;
  c.netem = "delay 50ms";
  c.ticks = 130;
  EntityId b = kNoEntity;
  Vec2 from;
  c.before_step = [&](Tick t, const Nodes& nodes) {
    const node::Replica& n = nodes[0]->replica();
    if (t == 100) {
      b = lonely_body(n);
      ASSERT_NE(b, kNoEntity);
      from = n.live().world().position(b);
      EXPECT_TRUE(n.may_push(b));
      nodes[0]->push(b, {3, 0});
      EXPECT_EQ(n.live().world().velocity(b).x, 0) << "nothing happens before the step";
    }
    if (t == 101) {
      EXPECT_GT(n.live().world().velocity(b).x, 2.5F);
    }
    if (t == 102) {
      EXPECT_EQ(n.agreed().predicted_state().authority[b].holder(), 0);
    }
    if (t == 103) {
      EXPECT_EQ(nodes[1]->replica().live().world().position(b), from) << "it cannot know yet";
    }
  };
  const RecordedRun run(c);
  const Vec2 here = run.nodes[0]->replica().live().world().position(b);
  const Vec2 there = run.nodes[1]->replica().live().world().position(b);
  EXPECT_GT(distance(here, from), 0.3F);
  EXPECT_LT(distance(here, there), 0.02F);
  EXPECT_EQ(run.nodes[1]->replica().agreed().predicted_state().authority[b].holder(), 0);
  expect_agreement(run);
  expect_replays(run);
}

TEST(Pushes, ManyAtATimeAndAgainstOneAnotherStayAgreedOn) {
  RunConfig c;
  c.seed = test::seed(11);
  c.peers = 3;
  c.netem = "delay 80ms 40ms loss 20%";
  c.ticks = 700;
  Rng rng(c.seed);
  c.before_step = [&](Tick t, const Nodes& nodes) {
    if (t % 40 != 0 || t > 500) return;
    for (const auto& n : nodes)
      for (int i = 0; i < 40; ++i) {
        const auto b =
            static_cast<EntityId>(rng.below(static_cast<std::uint32_t>(n->replica().live().world().bodies())));
        n->push(b, {static_cast<float>(rng.uniform(-6, 6)), static_cast<float>(rng.uniform(-6, 6))});
      }
  };
  const RecordedRun run(c);
  expect_agreement(run);
  expect_replays(run);
}

TEST(Pushes, NobodyPushesWhatAnotherHolds) {
  RunConfig c;
  c.netem = "";
  c.ticks = 600;
  int seen = 0;
  c.before_step = [&](Tick, const Nodes& nodes) {
    const sync::FoldState& p = nodes[1]->replica().agreed().predicted_state();
    for (EntityId b = 0; b < p.authority.size(); ++b) {
      if (p.authority[b].holder() != 0 || (p.holds[b] & 1U) == 0) continue;
      EXPECT_FALSE(nodes[1]->replica().may_push(b));
      ++seen;
    }
    EXPECT_FALSE(nodes[1]->replica().may_push(60000));
  };
  const RecordedRun run(c);
  EXPECT_GT(seen, 0);
}

TEST(Pushes, WithoutAuthorityEverybodyPushesForThemselves) {
  RunConfig c;
  c.technique = technique_by_name("avatar-only");
  c.netem = "";
  c.ticks = 60;
  c.before_step = [](Tick t, const Nodes& nodes) {
    if (t == 30) nodes[0]->push(0, {4, 0});
  };
  const RecordedRun run(c);
  EXPECT_NE(run.nodes[0]->replica().live().world().position(0), run.nodes[1]->replica().live().world().position(0));
  expect_replays(run);
}

TEST(Knobs, RecordsComeBackAsTheyWereWritten) {
  RunConfig c;
  c.ticks = 20;
  const Technique odd = technique_of("full --threshold 0.7:0.2");
  c.before_step = [&](Tick t, const Nodes& nodes) {
    if (t == 5) nodes[0]->retune(odd);
    if (t == 6) nodes[0]->push(3, {1.5F, -2});
    if (t == 7) nodes[0]->remark({"netem", 1, "delay 100ms"});
    if (t == 8) nodes[0]->remark({"pause", kNoPeer, ""});
  };
  const RecordedRun run(c);
  trace::TraceReader r(run.traces[0], "some.trace");
  std::set<std::string> seen;
  while (const auto e = r.next()) {
    if (const auto* t = std::get_if<trace::Retune>(&*e)) {
      seen.insert("retune");
      EXPECT_EQ(t->technique, odd);
    } else if (const auto* p = std::get_if<trace::Push>(&*e)) {
      seen.insert("push");
      EXPECT_EQ(p->body, 3);
      EXPECT_EQ(p->velocity, (Vec2{1.5F, -2}));
    } else if (const auto* m = std::get_if<trace::Remark>(&*e)) {
      seen.insert(m->kind);
      EXPECT_EQ(m->peer, m->kind == "netem" ? PeerId{1} : kNoPeer);
      EXPECT_EQ(m->text, m->kind == "netem" ? "delay 100ms" : "");
    }
  }
  EXPECT_EQ(seen, (std::set<std::string>{"retune", "push", "netem", "pause"}));
}

TEST(Knobs, ATraceThatBreaksTheirRulesIsRefused) {
  const auto error = [](const std::function<void(node::RecordedReplica&)>& write) -> std::string {
    RunConfig c;
    c.ticks = 10;
    c.before_step = [&](Tick t, const Nodes& nodes) {
      if (t == 5) write(*nodes[0]);
    };
    const RecordedRun run(c);
    try {
      return difference(run.traces[0]);
    } catch (const UserError& e) {
      return e.what();
    }
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_NE(error([](auto& n) { n.push(3, {2000, 0}); }).find("pushes too hard"), std::string::npos);
  EXPECT_NE(error([](auto& n) { n.push(5000, {1, 0}); }).find("pushes no body"), std::string::npos);
  EXPECT_NE(error([](auto& n) { n.remark({"cut", 30, ""}); }).find("is about no slot"), std::string::npos);
}

}  // namespace
}  // namespace padr
