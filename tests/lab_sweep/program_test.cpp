// padr-lab sweep and merge as a user meets them.
#include <algorithm>
#include <array>
#include <regex>

#include "tests/shell.h"

namespace padr {
namespace {

class SweepProgram : public test::Shell {
 protected:
  test::Outcome lab(const std::string& words) const { return shell(std::string("'") + PADR_LAB + "' " + words); }
};

TEST_F(SweepProgram, ShardsAndMergeGiveWhatOneSweepGives) {
  const std::string grid =
      "sweep --delay 0,50ms --loss 0,10% --technique fixed,full --bodies 8 --seeds 1-2 --seconds 0.5 ";
  ASSERT_EQ(lab(grid + "--csv whole.csv").status, 0);
  for (const char* i : {"1", "2", "3"}) {
    const auto r = lab(grid + "--shard " + i + "/3 --csv part" + i + ".csv");
    ASSERT_EQ(r.status, 0) << r.err;
  }
  const auto r = lab("merge part*.csv --out merged.csv --summary merged_means.csv");
  ASSERT_EQ(r.status, 0) << r.err;
  ASSERT_EQ(lab(grid + "--csv whole.csv --summary means.csv").status, 0);
  EXPECT_EQ(read("merged_means.csv"), read("means.csv"));
  EXPECT_EQ(std::ranges::count(read("means.csv"), '\n'), 1 + 8) << "a line for each combination";
  EXPECT_TRUE(r.out.starts_with("16 runs of 3 files in merged.csv\n")) << r.out;
  EXPECT_EQ(read("merged.csv"), read("whole.csv"));
}

TEST_F(SweepProgram, GoesOnAfterItWasKilled) {
  const std::string grid = "sweep --delay 0,50ms --seeds 1-20 --seconds 5 ";
  ASSERT_EQ(lab(grid + "--csv whole.csv").status, 0);
  shell(std::string("timeout -s KILL 0.2 '") + PADR_LAB + "' " + grid + "--jobs 1 --csv killed.csv");
  const auto r = lab(grid + "--csv killed.csv");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_EQ(read("killed.csv"), read("whole.csv"));
}

TEST_F(SweepProgram, MakesTheFolderOfItsFile) {
  const auto r = lab("sweep --seeds 1-2 --seconds 0.5 --csv rows/here/grid.csv --summary means/there/means.csv");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_EQ(std::ranges::count(read("rows/here/grid.csv"), '\n'), 3);
  EXPECT_EQ(std::ranges::count(read("means/there/means.csv"), '\n'), 2);
}

TEST_F(SweepProgram, ADryRunCountsAndRunsNothing) {
  const auto r = lab("sweep --seeds 1-20 --loss 0,5,10% --threshold 0.8,0.3:0.1 --seconds 3600 --dry-run");
  EXPECT_EQ(r.status, 0);
  EXPECT_NE(r.out.find(": 120 runs\n"), std::string::npos) << r.out;
}

TEST_F(SweepProgram, ADoubtfulNetworkIsNamedOnce) {
  const auto r = lab("sweep --delay 0,10,100ms --jitter 50ms --seeds 1-20 --dry-run");
  EXPECT_EQ(r.status, 0);
  EXPECT_NE(r.err.find("warning: in some runs: --netem: "), std::string::npos) << r.err;
  EXPECT_EQ(std::ranges::count(r.err, '\n'), 1) << r.err;
}

// Once, a row told of no delay and no loss where --netem had them, and nothing of what else all runs had alike.
TEST_F(SweepProgram, RowsTellWhatWasPlayed) {
  const std::string grid = "sweep --technique fixed --bodies 8 --seconds 0.5 ";
  // The heading, and of the row what comes before the seconds.
  const auto starts = [this](const std::string& file) {
    const std::string text = read(file);
    const std::size_t row = text.find('\n') + 1;
    return std::array{text.substr(0, row), text.substr(row, text.find(",0.5,", row) - row)};
  };
  ASSERT_EQ(lab(grid + "--netem 'delay 50ms 10ms loss 5% duplicate 1%' --csv a.csv").status, 0);
  EXPECT_TRUE(starts("a.csv")[0].starts_with(
      "grid,run,of,scenario,bodies,peers,delay_ms,jitter_ms,loss_percent,technique,netem,seed,seconds,mean_m,"));
  EXPECT_TRUE(starts("a.csv")[1].ends_with(",arena,8,2,50,10,5,fixed,delay 50ms 10ms loss 5% duplicate 1%,1"))
      << starts("a.csv")[1];
  ASSERT_EQ(lab(grid + "--netem 'lat 50ms drop 5%' --csv d.csv").status, 0);
  EXPECT_TRUE(starts("d.csv")[1].ends_with(",arena,8,2,50,0,5,fixed,lat 50ms drop 5%,1")) << starts("d.csv")[1];
  // A model of loss has no share that is its own.
  ASSERT_EQ(lab(grid + "--delay 50ms --netem 'loss gemodel 1% 30%' --csv b.csv").status, 0);
  EXPECT_TRUE(starts("b.csv")[1].ends_with(",arena,8,2,50,0,,fixed,loss gemodel 1% 30%,1")) << starts("b.csv")[1];
  ASSERT_EQ(lab(grid + "--input wander:3 --input rest --watch 1 --settle 2 --csv c.csv").status, 0);
  EXPECT_TRUE(
      starts("c.csv")[0].starts_with("grid,run,of,scenario,bodies,peers,delay_ms,jitter_ms,loss_percent,"
                                     "technique,input,watched_peer,settle_s,seed,seconds,mean_m,"));
  EXPECT_TRUE(starts("c.csv")[1].ends_with(",arena,8,2,0,0,0,fixed,wander:3 rest,1,2,1")) << starts("c.csv")[1];
}

// Once, the mean of the first few ticks was that of the run, without a word.
TEST_F(SweepProgram, WarnsWhereLittleWasConfirmedInTime) {
  const std::string warning =
      "padr-lab: warning: in 1 of 2 runs inconsistency was measured at a part of the ticks only, "
      "in run 1 at the first ";
  const std::string grid = "sweep --delay 0,3s --seconds 4 ";
  for (const char* time : {"first", "again, with nothing left to play"})
    EXPECT_TRUE(lab(grid + "--csv a.csv").err.starts_with(warning)) << time;
  for (const char* i : {"1", "2"}) lab(grid + "--shard " + i + "/2 --csv part" + i + ".csv");
  EXPECT_TRUE(lab("merge part1.csv part2.csv --out b.csv").err.starts_with(warning));
  EXPECT_EQ(lab("sweep --seconds 4 --csv c.csv").err, "");
}

// Once, only the rows that were new counted.
TEST_F(SweepProgram, WorldsThatDifferAreNeverExit0) {
  const std::string grid = "sweep --seeds 1-2 --seconds 0.5 ";
  for (const char* i : {"1", "2"}) ASSERT_EQ(lab(grid + "--shard " + i + "/2 --csv part" + i + ".csv").status, 0);
  ASSERT_EQ(lab("merge part1.csv part2.csv --out whole.csv").status, 0);
  const std::string differing = std::regex_replace(read("part2.csv"), std::regex(",0,([0-9a-f]{16},)"), ",3,$1");
  ASSERT_NE(differing, read("part2.csv"));
  write("part2.csv", differing);
  for (const auto& command : {grid + "--shard 2/2 --csv part2.csv",
                              std::string("merge part1.csv part2.csv --out whole.csv"), grid + "--csv whole.csv"}) {
    const auto r = lab(command);
    EXPECT_EQ(r.status, 1) << command;
    EXPECT_EQ(r.err, "padr-lab: confirmed worlds differed: see the column confirmed_mismatches\n") << command;
  }
}

TEST_F(SweepProgram, WhatIsNoOptionIsNamedWithAGuess) {
  EXPECT_EQ(lab("sweep --sedes 1 --dry-run").err,
            "padr-lab: '--sedes' is no option here; did you mean --seeds? (see --help)\n");
  EXPECT_EQ(lab("sweep --quite-another --dry-run").err, "padr-lab: '--quite-another' is no option here (see --help)\n");
  EXPECT_EQ(lab("sweep --netem duplicate 1% --dry-run").err,
            "padr-lab: '1%' is one word too many; put a value that has spaces in quotes (see --help)\n");
}

TEST_F(SweepProgram, MistakesAreOneLineAndExit2) {
  const auto refused = [this](const std::string& words, const std::string& begin) {
    const auto r = lab(words);
    EXPECT_EQ(r.status, 2) << words;
    EXPECT_TRUE(r.err.starts_with("padr-lab: " + begin)) << r.err;
    EXPECT_EQ(r.err.find('\n'), r.err.size() - 1) << r.err;
    EXPECT_FALSE(std::filesystem::exists(path("x.csv"))) << words;
  };
  refused("sweep --delay 50 --csv x.csv", "--delay: '50' is not allowed; give times from 0 to 60 s");
  refused("sweep --loss 0,101 --csv x.csv", "--loss: '101' is not allowed; give percentages from 0 to 100");
  refused("sweep --peers 65 --csv x.csv", "--peers: '65' is not allowed; give whole numbers from 1 to 64");
  refused("sweep --seeds x --csv x.csv", "--seeds: 'x' is not allowed; give whole numbers from 0 to");
  refused("sweep --predictor full --csv x.csv", "--predictor: 'full' is not allowed; give one of none");
  refused("sweep --shard 0/3 --csv x.csv", "--shard: '0/3' is not allowed; give I/N");
  refused("sweep --seconds nan --csv x.csv", "--seconds: 'nan' is not allowed; give 0.1 to 86400 seconds");
  refused("sweep --shard 1/3 --csv x.csv --summary y.csv", "--summary with --shard:");
  refused("sweep --peers 1,2 --input rest --input wander --input rest --csv x.csv",
          "--input: given 3 times, but --peers is 2");
  refused("sweep --scenario 'my\nscene' --csv x.csv", "--scenario: a value with a line break is not allowed");
  refused("sweep", "--csv is required");
  refused("merge nothing.csv --out x.csv", "SHARD:");
}

}  // namespace
}  // namespace padr
