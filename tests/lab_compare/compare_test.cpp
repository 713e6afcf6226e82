#include <gtest/gtest.h>

#include <algorithm>

#include "common/link/netem_spec.h"
#include "common/model/ids.h"
#include "common/model/user_error.h"
#include "tools/lab/compare/comparison.h"

namespace padr::lab::compare {
namespace {

Plan plan(const std::string& techniques, int seeds) {
  Technique full = technique_by_name("full");
  set_threshold(full, "0.3:0.1");
  set_body_threshold(full, "0.05");
  Plan p;
  p.contestants = chosen_contestants(techniques, full);
  p.setting.ticks = 10 * kTicksPerSecond;
  for (const char* netem : {"delay 0ms", "delay 100ms"})
    p.networks.push_back({netem, link::parse_netem(netem, nullptr)});
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
  Plan p = plan("fixed,full,snapshot-20,state-sync-20,dis", 1);
  p.networks = {{"bad", link::parse_netem("delay 60ms 30ms loss 10% duplicate 2% corrupt 1%", nullptr)}};
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
  const Technique full = technique_by_name("full");
  EXPECT_EQ(chosen_contestants("all", full).size(), all_contestants(full).size());
  const std::vector<Contestant> some = chosen_contestants("dis,paper,dis", full);
  ASSERT_EQ(some.size(), 4U);
  EXPECT_EQ(some.back().id, "dis");
  for (const char* wrong : {"", "fulll", "full,,dis", "full,none"}) {
    try {
      chosen_contestants(wrong, full);
      FAIL() << wrong;
    } catch (const UserError& e) {
      const std::string line = e.what();
      EXPECT_TRUE(line.starts_with("--techniques: '")) << line;
      EXPECT_NE(line.find("state-sync-20"), std::string::npos);
    }
  }
}

TEST(Compare, TooManyPeersIsTheUsersMistake) {
  Plan p = plan("full", 1);
  p.setting.peers = kMaxPeers + 1;
  EXPECT_THROW(run_plan(p), UserError);
}

}  // namespace
}  // namespace padr::lab::compare
