#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/model/ids.h"
#include "common/model/user_error.h"
#include "shell/netem_text.h"
#include "shell/technique_text.h"
#include "tools/lab/compare/comparison.h"
#include "tools/lab/compare/fields.h"
#include "tools/plot/plot.h"

namespace padr::lab::compare {
namespace {

Plan plan(const std::string& techniques, int seeds) {
  Plan p;
  p.contestants = chosen_contestants(techniques);
  p.setting.ticks = 10 * kTicksPerSecond;
  for (const char* netem : {"delay 0ms", "delay 100ms"})
    p.networks.push_back({netem, shell::parse_netem(netem, nullptr)});
  for (int s = 1; s <= seeds; ++s) p.seeds.push_back(static_cast<std::uint64_t>(s));
  p.parallel.quiet = true;
  return p;
}

TEST(Compare, NoAlternativeBeatsFullInBoth) {
  const Plan p = plan("full,alternatives", 2);
  const std::vector<Row> rows = run_plan(p);
  for (const Row& r : rows) {
    EXPECT_NE(standing(r, rows), Standing::kDominates) << r.who.id << " at " << r.network << "\n" << table(rows, p);
    EXPECT_NE(standing(r, rows), Standing::kNoFull);
    for (const Score& s : r.scores) EXPECT_EQ(s.mismatches, 0U) << r.who.id;
  }
}

TEST(Compare, SameSeedSameResult) {
  Plan p = plan("fixed-0.5,full,snapshot-20,state-sync-20,dis", 1);
  p.networks = {{"bad", shell::parse_netem("delay 60ms 30ms loss 10% duplicate 2% corrupt 1%", nullptr)}};
  p.parallel.threads = 2;
  const std::string first = csv(run_plan(p), p);
  p.parallel.threads = 1;
  EXPECT_EQ(csv(run_plan(p), p), first);
}

TEST(Compare, StandingIsDecidedByBothMeasures) {
  const auto row = [](const char* id, double m, double kbps) {
    Row r;
    r.who.id = id;
    r.network = "n";
    Score s;
    s.off.mean_m = m;
    s.kbps = kbps;
    r.scores = {s};
    return r;
  };
  const std::vector<Row> rows{row("full", 1, 10),   row("better", 0.9, 9),   row("closer", 0.9, 11),
                              row("cheaper", 2, 9), row("worse", 1.1, 10.5), row("same", 1, 10)};
  const std::vector<Standing> expected{Standing::kIsFull, Standing::kDominates, Standing::kTrades,
                                       Standing::kTrades, Standing::kWorse,     Standing::kWorse};
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(standing(rows[i], rows), expected[i]) << rows[i].who.id;
  EXPECT_EQ(standing(rows[1], {rows[1]}), Standing::kNoFull);
}

TEST(Compare, ListsOfTechniques) {
  EXPECT_EQ(chosen_contestants("all,frontier").size(), all_contestants().size());
  const std::vector<Contestant> curves = chosen_contestants("frontier");
  EXPECT_EQ(std::count_if(curves.begin(), curves.end(), is_budget_of_full), 5);
  for (const Contestant& c : chosen_contestants("all")) EXPECT_NE(c.group, Group::kFrontier) << c.id;
  const std::vector<Contestant> some = chosen_contestants("dis,paper,dis");
  ASSERT_EQ(some.size(), 7U);
  EXPECT_EQ(some.back().id, "dis");
  for (const char* wrong : {"", "fulll", "full,,dis", "full,none"}) {
    try {
      chosen_contestants(wrong);
      FAIL() << wrong;
    } catch (const UserError& e) {
      const std::string line = e.what();
      EXPECT_TRUE(line.starts_with("--techniques: '")) << line;
      EXPECT_NE(line.find("state-sync-20"), std::string::npos);
    }
  }
}

TEST(Compare, OneNameIsOneSetting) {
  for (const Contestant& c : all_contestants()) {
    const auto* t = std::get_if<Technique>(&c.how);
    if (c.id == "full") {
      EXPECT_EQ(*t, technique_by_name("full"));
    }
    if (c.id.starts_with("fixed-")) {
      EXPECT_NE(c.what.find(c.id.substr(6, 3) + " m"), std::string::npos) << c.what;
    }
  }
  const Plan p = plan("full,fixed-0.3", 1);
  const std::string text = table({}, p);
  for (const Contestant& c : p.contestants)
    EXPECT_NE(text.find(shell::describe(std::get<Technique>(c.how))), std::string::npos);
}

TEST(Compare, AContestantIsAddedByItsKnobs) {
  const Contestant c = added_contestant("full --lead 0.2 --unowned=live");
  EXPECT_EQ(c.id, "full --lead 0.2 --unowned=live");
  const auto& t = std::get<Technique>(c.how);
  EXPECT_EQ(t.lead, 0.2F);
  EXPECT_EQ(t.unowned, Unowned::kLive);
  EXPECT_EQ(t.threshold_high, technique_by_name("full").threshold_high);
  for (const auto& [text, part] :
       {std::pair{"", "avatar-only"}, std::pair{"full --led 1", "--lead"}, std::pair{"full --lead", "no value"},
        std::pair{"full --lead 7", "0 to 1 seconds"}, std::pair{"rollback --lead 1", "--input-delay"},
        std::pair{"rollback --input-delay 61", "0 to 60 ticks"}, std::pair{"rollback --input-delay", "0 to 60 ticks"},
        std::pair{"rollback --hz 7", "a divisor of 60"}, std::pair{"lockstep --prediction 3", "no knob of lockstep"},
        std::pair{"dis --threshold nan", "0.001 to 100 m"}, std::pair{"state-sync --hz 2.5", "1 to 60"}}) {
    try {
      added_contestant(text);
      FAIL() << text;
    } catch (const UserError& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }
}

TEST(Compare, AnAlternativeIsAddedByItsKnobs) {
  const auto spec = std::get<alternatives::Spec>(added_contestant("rollback --input-delay 3 --hz=20").how);
  EXPECT_EQ(spec.kind, alternatives::Kind::kInputs);
  EXPECT_EQ(spec.input_delay, 3);
  EXPECT_EQ(spec.hz, 20);
  EXPECT_EQ(spec.prediction, alternatives::kGgpoPrediction);
  EXPECT_EQ(std::get<alternatives::Spec>(added_contestant("lockstep").how).prediction, 0);
}

TEST(Compare, FullIsTakenAtTheBudgetThatSendsNoMore) {
  const auto row = [](const char* text, double m, double kbps) {
    Row r;
    r.who = added_contestant(text);
    r.scores.emplace_back();
    r.scores.back().off.mean_m = m;
    r.scores.back().kbps = kbps;
    return r;
  };
  const std::vector<Row> rows{row("full --budget 8", 0.4, 8), row("full", 0.1, 30), row("full --lead 0", 0.01, 9),
                              row("rollback", 0.2, 20), row("dis", 1, 7)};
  EXPECT_EQ(full_for_no_more(rows[3], rows), 0.4);
  EXPECT_EQ(full_for_no_more(rows[1], rows), 0.1);
  EXPECT_EQ(full_for_no_more(rows[4], rows), std::nullopt);
}

TEST(Compare, ErrorsByHand) {
  Row r;
  for (const double m : {1.0, 2.0, 3.0, 6.0}) {
    r.scores.emplace_back();
    r.scores.back().off.mean_m = m;
  }
  const Figure f = r.over([](const Score& s) { return s.off.mean_m; });
  EXPECT_DOUBLE_EQ(f.mean, 3);
  EXPECT_NEAR(f.error, std::sqrt(14.0 / 3 / 4), 1e-12);
}

// Once, a seed without jumps counted as one with jumps of 0 m: less than a jump can be.
TEST(Compare, TheSizeOfJumpsIsThatOfSeedsThatHadAny) {
  const auto jump = std::find_if(fields().begin(), fields().end(),
                                 [](const Field& f) { return f.name == std::string("jump_mean_m"); });
  Row r;
  r.scores.resize(4);
  EXPECT_EQ(r.over(jump->of, jump->has).mean, 0);
  r.scores[1].jumps = 0.5;
  r.scores[1].jump_m = 0.04;
  r.scores[3].jumps = 0.1;
  r.scores[3].jump_m = 0.06;
  const Figure f = r.over(jump->of, jump->has);
  EXPECT_DOUBLE_EQ(f.mean, 0.05);
  EXPECT_EQ(f.low, 0.04);
  EXPECT_NEAR(f.error, 0.01, 1e-12);
}

TEST(Compare, TooManyPeersIsTheUsersMistake) {
  Plan p = plan("full", 1);
  p.setting.peers = kMaxPeers + 1;
  EXPECT_THROW(run_plan(p), UserError);
}

// gnuplot takes a logarithmic axis for a nonlinear one: undoing nonlinear after that leaves it linear.
TEST(Frontier, HasLogarithmicAxes) {
  plot::ScatterPlot p;
  p.name = "frontier";
  p.x.log = p.y.log = true;
  p.series.push_back({.title = "full", .marks = {{1, 0.01, "a"}, {10, 100, "b"}}});
  const auto files = plot::files(p);
  const auto script = std::find_if(files.begin(), files.end(), [](const auto& f) { return f.name == "frontier.gp"; });
  ASSERT_NE(script, files.end());
  for (const std::string axis : {"x", "y"}) {
    const auto log = script->text.rfind("set logscale " + axis);
    ASSERT_NE(log, std::string::npos);
    EXPECT_LT(script->text.rfind("unset nonlinear " + axis), log);
  }
}

}  // namespace
}  // namespace padr::lab::compare
