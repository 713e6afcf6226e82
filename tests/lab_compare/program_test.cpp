// padr-lab compare and benchmark as a user meets them.
#include "tests/shell.h"

namespace padr {
namespace {

class CompareProgram : public test::Shell {
 protected:
  test::Outcome lab(const std::string& words, const std::string& before = "") const {
    return shell(before + " '" + PADR_LAB + "' " + words);
  }
  void refused(const std::string& words, const std::string& begin) const {
    const auto r = lab(words);
    EXPECT_EQ(r.status, 2) << words;
    EXPECT_TRUE(r.err.starts_with("padr-lab: " + begin)) << words << ": " << r.err;
  }
};

TEST_F(CompareProgram, ARefusedCommandLineTouchesNoFile) {
  write("old.json", "{}");
  write("old.csv", "a,b\n");
  const std::string files = " --json old.json --csv old.csv";
  refused("compare --scenario nowhere" + files, "--scenario: 'nowhere' is neither a file nor one of ");
  refused("compare --scenario ball --peers 60" + files, "--peers: 60 is too many for scenario ball");
  refused("compare --input path:nowhere.csv" + files, "--input: ");
  refused("compare --input sleep" + files, "--input: ");
  refused("compare --peers 1 --input rest --input wander" + files, "--input: given 2 times, but --peers is 1");
  refused("compare --json old.json --csv no/where.csv", "--csv: cannot write 'no/where.csv'");
  refused("compare --json new.json --csv no/where.csv", "--csv: cannot write 'no/where.csv'");
  EXPECT_EQ(read("old.json"), "{}");
  EXPECT_EQ(read("old.csv"), "a,b\n");
  EXPECT_FALSE(std::filesystem::exists(path("new.json")));
}

// Once, the second one's pictures replaced the first one's.
TEST_F(CompareProgram, NetworksThatDifferInSpacesAreOne) {
  refused("compare --netem 'delay 10ms' --netem ' delay  10ms' --out results",
          "--netem: ' delay  10ms' is played already; give every one once");
}

TEST_F(CompareProgram, ADryBenchmarkRefusesWhatTheRunRefuses) {
  for (const char* dry : {"", " --dry-run"})
    for (const auto& [words, begin] : {std::pair("--scenario ball --peers 60", "--peers: 60 is too many"),
                                       std::pair("--peers 1 --input rest --input rest", "--input: given 2 times")})
      refused(std::string("benchmark --out results ") + words + dry, begin);
  EXPECT_FALSE(std::filesystem::exists(path("results")));
}

TEST_F(CompareProgram, WarnsWhereLittleWasConfirmedInTime) {
  const std::string words = " --techniques full --seeds 1 --seconds 4 --netem 'delay 0ms' --netem 'delay 3s'";
  for (const char* command : {"compare", "benchmark --out results"}) {
    const auto r = lab(command + words);
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_TRUE(
        r.err.starts_with("padr-lab: warning: full, netem 'delay 3s': inconsistency was measured at the first "))
        << command << ": " << r.err;
  }
}

// Once, only standard error said so, and of a benchmark only while it played: what remained showed a mean of 0.
TEST_F(CompareProgram, WhatIsHardlyMeasuredSaysSoWhereItIsShown) {
  const std::string words = " --techniques full,dis --seeds 1 --seconds 4 --netem 'delay 0ms' --netem 'delay 3s'";
  const std::string note = "Few ticks were confirmed in time, so only these were measured: full (";
  const auto times = [&note](const std::string& text) {
    std::size_t n = 0;
    for (std::size_t at = text.find(note); at != std::string::npos; at = text.find(note, at + 1)) ++n;
    return n;
  };
  const auto r = lab("compare" + words + " --csv a.csv");
  EXPECT_EQ(times(r.out), 1U) << r.out;
  EXPECT_NE(read("a.csv").find(",measured_share,"), std::string::npos);
  for (const char* time : {"first", "again, with nothing left to play"}) {
    EXPECT_NE(lab("benchmark --out results" + words).err, "") << time;
    EXPECT_EQ(times(read("results/results.txt")), 1U) << time;
    EXPECT_EQ(times(read("results/index.html")), 1U) << time;
  }
}

TEST_F(CompareProgram, AGnuplotThatFailsIsExit1AndLeavesNoOlderPicture) {
  std::filesystem::create_directories(path("bin"));
  write("bin/gnuplot", "#!/bin/sh\nexit 3\n");
  std::filesystem::permissions(path("bin/gnuplot"), std::filesystem::perms::owner_all);
  for (const std::string command : {"compare", "benchmark"}) {
    std::filesystem::create_directories(path(command));
    write(command + "/frontier_delay_50ms.svg", "old");
    const auto r = lab(command + " --techniques full,dis --seeds 1 --seconds 1 --netem 'delay 50ms' --out " + command,
                       "PATH='" + path("bin") + "':$PATH");
    EXPECT_EQ(r.status, 1) << command;
    EXPECT_EQ(r.err, "padr-lab: gnuplot failed on " + command + "/frontier_delay_50ms.gp\n");
    EXPECT_FALSE(std::filesystem::exists(path(command + "/frontier_delay_50ms.svg"))) << command;
  }
}

}  // namespace
}  // namespace padr
