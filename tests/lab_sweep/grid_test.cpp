// Grids: every combination once, in one order, and what makes two of them the same.
#include "tools/lab/sweep/grid.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "shell/netem_text.h"
#include "shell/technique_text.h"
#include "tests/lab_sweep/error_of.h"
#include "tools/lab/sweep/sweep.h"

namespace padr::lab::sweep {
namespace {

using test::error_of;

GridText text() {
  GridText t;
  t.knobs.resize(shell::knobs().size());
  return t;
}

std::string& knob(GridText& t, std::string_view flag) {
  for (std::size_t k = 0; k < shell::knobs().size(); ++k)
    if (shell::knobs()[k].flag == flag) return t.knobs[k];
  ADD_FAILURE() << flag;
  return t.knobs[0];
}

TEST(Grid, HasEveryCombinationOnce) {
  GridText t = text();
  t.delay = "0,50ms";
  t.loss = "0,10%";
  t.peers = "2,3";
  t.bodies = "5,9";
  t.techniques = "fixed,full";
  t.seeds = "1-3";
  knob(t, "--threshold") = "0.8,0.3:0.1";
  const Grid grid(t);
  ASSERT_EQ(grid.size(), 2U * 2 * 2 * 2 * 2 * 3 * 2);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const Point p = grid.point(i);
    seen.insert(std::to_string(p.delay_ms) + " " + std::to_string(p.loss_percent.value_or(-1)) + " " +
                std::to_string(p.peers) + " " + std::to_string(p.bodies.value_or(0)) + " " +
                shell::describe(p.technique) + " " + std::to_string(p.seed));
  }
  EXPECT_EQ(seen.size(), grid.size());
  EXPECT_EQ(grid.point(0).seed, 1U);
  EXPECT_EQ(grid.point(2).seed, 3U);
  EXPECT_EQ(grid.point(3).technique.threshold_low, 0.1F) << "after the seeds, the last knob";
}

TEST(Grid, ReachesTheLinks) {
  GridText t = text();
  t.delay = "50ms";
  t.jitter = "20ms";
  t.loss = "10%";
  t.netem = "duplicate 1%";
  EXPECT_EQ(shell::to_string(Grid(t).point(0).netem), "delay 50ms 20ms loss 10% duplicate 1%");
  EXPECT_EQ(shell::to_string(Grid(text()).point(0).netem), "");
}

TEST(Grid, ItsIdIsThatOfItsRuns) {
  const std::string id = Grid(text()).id();
  EXPECT_EQ(id.size(), 8U);
  EXPECT_EQ(Grid(text()).id(), id);
  GridText same = text();
  same.delay = "0";
  EXPECT_EQ(Grid(same).id(), id) << "what is given is the default";
  GridText other = text();
  other.seconds = 61;
  EXPECT_NE(Grid(other).id(), id);
  other = text();
  other.seeds = "2";
  EXPECT_NE(Grid(other).id(), id);
  other = text();
  knob(other, "--replay") = "off";
  EXPECT_NE(Grid(other).id(), id);
}

TEST(Grid, ItsIdHasWhatIsInAFileOfALinkTrace) {
  const std::string file = ::testing::TempDir() + "padr-grid-test.link";
  GridText t = text();
  t.netem = "trace " + file;
  const auto id_with = [&](const char* times) {
    std::ofstream(file) << times;
    return Grid(t).id();
  };
  const std::string id = id_with("5\n");
  EXPECT_EQ(id_with("5\n"), id);
  EXPECT_NE(id_with("6\n"), id);
  std::filesystem::remove(file);
}

struct Bad {
  const char* what;
  void (*make)(GridText&);
  const char* message;  ///< how it begins
};

TEST(Grid, BadOnesAreRefusedBeforeAnythingRuns) {
  const std::vector<Bad> all{
      {"peers", [](GridText& t) { t.peers = "2,65"; }, "--peers: '65' is not allowed; give whole numbers from 1 to 64"},
      {"places", [](GridText& t) { t.scenarios = "arena,van", t.peers = "2,5"; },
       "--peers: '5' is not allowed for scenario van; give 1 to 4"},
      {"places between bodies", [](GridText& t) { t.peers = "64", t.bodies = "120,170"; },
       "--peers: '64' is not allowed for scenario arena with --bodies 170; give 1 to "},
      {"bodies", [](GridText& t) { t.bodies = "5001"; }, "--bodies: '5001' is not allowed; give whole numbers from 1"},
      {"no room", [](GridText& t) { t.bodies = "3000"; }, "--bodies 3000: arena:"},
      {"no scatter", [](GridText& t) { t.scenarios = "van", t.bodies = "9"; }, "--bodies 9: van:1:1: has neither"},
      {"scenario", [](GridText& t) { t.scenarios = "arena,nix"; }, "--scenario: 'nix' is neither a file nor one of"},
      {"technique", [](GridText& t) { t.techniques = "full,fast"; }, "--technique: 'fast' is not allowed; give one of"},
      {"knob", [](GridText& t) { knob(t, "--threshold") = "0.3:0.8"; }, "--threshold: '0.3:0.8' is not allowed"},
      {"knob", [](GridText& t) { knob(t, "--steps") = "30,601"; }, "--steps: '601' is not allowed; give 1 to 600"},
      {"input", [](GridText& t) { t.inputs = {"walk"}; }, "--input: \"walk\" is no input"},
      {"netem", [](GridText& t) { t.netem = "lose 3%"; }, "--netem: word 1 \"lose\""},
      {"two delays", [](GridText& t) { t.netem = "loss 3% delay 5ms", t.delay = "0,10ms"; },
       "--netem: 'loss 3% delay 5ms' has a delay, and so has --delay; give"},
      {"a knob of two", [](GridText& t) { t.techniques = "full,full --steps 20", knob(t, "--steps") = "30"; },
       "--steps: 'full --steps 20' of --technique sets it, too; give"},
      {"size", [](GridText& t) { t.seeds = "1-1000000", t.peers = "1-16"; }, "the grid has more than 10 million runs"},
  };
  for (const Bad& bad : all) {
    GridText t = text();
    bad.make(t);
    const std::string message = error_of([&] { Grid{t}; });
    EXPECT_TRUE(message.starts_with(bad.message)) << bad.what << ": " << message;
  }
}

TEST(Shards, AreDisjointAndComplete) {
  for (std::size_t count : {1U, 3U, 7U})
    for (std::size_t run = 0; run < 20; ++run) {
      int owners = 0;
      for (std::size_t i = 1; i <= count; ++i) owners += Shard{i, count}.has(run) ? 1 : 0;
      EXPECT_EQ(owners, 1);
    }
}

TEST(Shards, AreWrittenAsPartOfAll) {
  EXPECT_EQ(shard_of("").count, 1U);
  EXPECT_EQ(shard_of("8/8").index, 8U);
  for (const char* bad : {"0/3", "4/3", "1", "1/", "/3", "a/b", "1/2/3", "-1/3", "1/1000001"})
    EXPECT_EQ(error_of([&] { shard_of(bad); }), "--shard: '" + std::string(bad) +
                                                    "' is not allowed; give I/N with I from 1 to N, and N up to "
                                                    "1000000");
}

TEST(Grid, TechniquesMayBringTheirKnobs) {
  GridText t = text();
  t.techniques = "fixed --threshold 0.8,fixed --threshold 0.3,full";
  t.seeds = "1";
  const Grid grid(t);
  ASSERT_EQ(grid.size(), 3U);
  EXPECT_EQ(grid.point(0).technique.threshold_high, 0.8F);
  EXPECT_EQ(grid.point(1).technique_name, "fixed --threshold 0.3");
  EXPECT_EQ(grid.point(1).technique.threshold_high, 0.3F);
  EXPECT_EQ(grid.point(2).technique, technique_by_name("full"));
}

}  // namespace
}  // namespace padr::lab::sweep
