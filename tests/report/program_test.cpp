// padr-report as a user meets it: files in, exit code and text out.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/trace/recorded_run.h"
#include "tools/plot/palette.h"

namespace padr {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int status = -1;
  std::string out;
  std::string err;
};

std::string read(const fs::path& p) {
  std::ifstream in(p, std::ios::binary);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

class Program : public testing::Test {
 protected:
  void SetUp() override {
    dir_ =
        fs::path(testing::TempDir()) / ("padr_report_" + std::string(info()->name()) + "_" + std::to_string(getpid()));
    fs::create_directories(dir_);
    write_run("", {});
  }
  void TearDown() override { fs::remove_all(dir_); }

  static const testing::TestInfo* info() { return testing::UnitTest::GetInstance()->current_test_info(); }

  void write(const std::string& name, const std::vector<std::byte>& bytes) {
    std::ofstream out(dir_ / name, std::ios::binary);
    for (const std::byte b : bytes) out.put(static_cast<char>(b));
  }
  /// PREFIX0.trace, PREFIX1.trace.
  void write_run(const std::string& prefix, test::RunConfig c) {
    const test::RecordedRun run(c);
    for (std::size_t p = 0; p < run.traces.size(); ++p) write(prefix + std::to_string(p) + ".trace", run.traces[p]);
  }

  /// Runs padr-report in the test's folder with these words, by the shell.
  Outcome run(const std::string& words, const std::string& before = "") {
    const std::string command =
        "cd '" + dir_.string() + "' && " + before + " '" + PADR_REPORT + "' " + words + " >out 2>err";
    const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): a test of what a shell user sees
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(dir_ / "out"), read(dir_ / "err")};
  }

  fs::path dir_;
};

TEST_F(Program, TableByDefault) {
  const Outcome o = run("1.trace 0.trace");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err, "");
  for (const char* expected : {"arena (seed 1), 60 bodies, 2 peers, 5.0 s", "below about 5 mm it is noise", "kbit/s",
                               "0 -> 1", "1 -> 0", "overall", "Confirmed worlds: identical at all"})
    EXPECT_NE(o.out.find(expected), std::string::npos) << expected << " in\n" << o.out;
  EXPECT_LT(o.out.find("peer 0"), o.out.find("peer 1"));
}

// Once, a single trace had a cost of 0.
TEST_F(Program, CostIsMeasuredInOthersViewsOnly) {
  const Outcome both = run("0.trace 1.trace --json - --csv both");
  EXPECT_NE(both.out.find("pcc_mean_m"), std::string::npos);
  const Outcome one = run("0.trace --json - --csv one");
  EXPECT_EQ(one.status, 0) << one.err;
  EXPECT_EQ(one.out.find("pcc_"), std::string::npos);
  EXPECT_NE(one.out.find("fidelity_mean_m"), std::string::npos);
  const auto ends_without_cost = [this](const char* folder) {
    std::istringstream lines(read(dir_ / folder / "fidelity.csv"));
    std::string line;
    std::getline(lines, line);
    return std::getline(lines, line) && line.ends_with(",,");
  };
  EXPECT_TRUE(ends_without_cost("one"));
  EXPECT_FALSE(ends_without_cost("both"));
  EXPECT_EQ(run("0.trace").out.find("avatar 0 "), std::string::npos);
}

TEST_F(Program, JsonToStandardOutputIsNothingElse) {
  const Outcome o = run("0.trace 1.trace --json -");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.out.rfind("{\n", 0), 0U);
  EXPECT_EQ(o.out.substr(o.out.size() - 2), "}\n");
  for (const char* key : {"mean_m",
                          "avatar_mean_m",
                          "body_mean_m",
                          "p95_m",
                          "p99_m",
                          "peak_m",
                          "final_m",
                          "area_ms",
                          "shown_mean_m",
                          "updates_per_s",
                          "datagrams_per_s",
                          "wire_kbps",
                          "updates_by_cause",
                          "confirmed_ticks",
                          "confirmed_mismatches",
                          "replay_steps_per_tick",
                          "netem_seed",
                          "revision",
                          "scenario_seed",
                          "command",
                          "links",
                          "loss_percent",
                          "by_technique",
                          "by_peer"})
    EXPECT_NE(o.out.find('"' + std::string(key) + '"'), std::string::npos) << key;
}

TEST_F(Program, TableAndSummaryTellHowShownPositionsMove) {
  const Outcome o = run("0.trace 1.trace --json j.json");
  EXPECT_EQ(o.status, 0) << o.err;
  const std::size_t at = o.out.find("\n  shown  ");
  ASSERT_NE(at, std::string::npos);
  const std::string rows = o.out.substr(at, o.out.find("\n\n", at) - at);
  for (const char* row : {"\n  peer 0 ", "\n  peer 1 ", "\n  overall "})
    EXPECT_NE(rows.find(row), std::string::npos) << row;
  EXPECT_NE(read(dir_ / "j.json").find("\"overlap_made_mean_m\""), std::string::npos);
}

TEST_F(Program, FilesWhereTheyWereAskedFor) {
  const Outcome o = run("0.trace 1.trace --csv deep/csv --json j.json");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find("overall"), std::string::npos) << "the table as well";
  EXPECT_EQ(read(dir_ / "deep/csv/inconsistency.csv")
                .rfind("peer,tick,seconds,combined_m,avatar_m,body_m,shown_m\n0,0,0.0000,", 0),
            0U);
  for (const char* name : {"traffic", "links", "authority"})
    EXPECT_GT(read(dir_ / "deep/csv" / (std::string(name) + ".csv")).size(), 50U) << name;
  EXPECT_GT(read(dir_ / "j.json").size(), 1000U);
}

TEST_F(Program, PlotsAsSvgAndPng) {
  if (std::system("command -v gnuplot >/dev/null") != 0) GTEST_SKIP() << "no gnuplot";  // NOLINT(cert-env33-c)
  const Outcome o = run("0.trace 1.trace --plots \"it's plots\"");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.err, "");
  for (const char* name : {"inconsistency", "traffic", "authority"}) {
    const fs::path base = dir_ / "it's plots" / name;
    EXPECT_NE(read(base.string() + ".svg").find("</svg>"), std::string::npos) << name;
    EXPECT_EQ(read(base.string() + ".png").substr(1, 3), "PNG") << name;
  }
}

// Once, it exited with 0, and the picture of an earlier report stood for this one's.
TEST_F(Program, AGnuplotThatFailsLeavesNoOlderPicture) {
  fs::create_directories(dir_ / "bin");
  fs::create_directories(dir_ / "p");
  std::ofstream(dir_ / "bin/gnuplot") << "#!/bin/sh\necho half >${1%.gp}.svg\nexit 3\n";
  fs::permissions(dir_ / "bin/gnuplot", fs::perms::owner_all);
  for (const char* old : {"inconsistency.svg", "traffic.png"}) std::ofstream(dir_ / "p" / old) << "old";
  const Outcome o = run("0.trace 1.trace --plots p", "PATH='" + (dir_ / "bin").string() + "':$PATH");
  EXPECT_EQ(o.status, 1);
  EXPECT_EQ(o.err, "padr-report: gnuplot failed on p/inconsistency.gp\n");
  EXPECT_NE(o.out.find("Confirmed worlds: identical"), std::string::npos);
  for (const char* gone : {"inconsistency.svg", "traffic.png"}) EXPECT_FALSE(fs::exists(dir_ / "p" / gone)) << gone;
  EXPECT_TRUE(fs::exists(dir_ / "p/traffic.gp"));
}

TEST_F(Program, WithoutGnuplotItSaysHowToGetItAndGoesOn) {
  const Outcome o = run("0.trace 1.trace --plots p", "PATH=/nowhere");
  EXPECT_EQ(o.status, 0);
  EXPECT_NE(o.err.find("apt-get install gnuplot-nox"), std::string::npos) << o.err;
  EXPECT_NE(o.out.find("Confirmed worlds: identical"), std::string::npos);
  EXPECT_TRUE(fs::exists(dir_ / "p/traffic.gp"));
}

TEST_F(Program, ThePlotsColourIsThatOfThePeersSlotWhateverTraceIsFirst) {
  run("1.trace --plots p", "PATH=/nowhere");
  const std::string script = read(dir_ / "p/inconsistency.gp");
  const auto at = script.find("title 'peer 1'");
  ASSERT_NE(at, std::string::npos) << script;
  EXPECT_NE(script.rfind(plot::colour_by_number(1), at), std::string::npos) << script;
  EXPECT_EQ(script.find(plot::colour_by_number(0)), std::string::npos) << script;
}

TEST_F(Program, ATraceThatBreaksOffIsUsedAsFarAsItGoes) {
  fs::resize_file(dir_ / "1.trace", fs::file_size(dir_ / "1.trace") - 1000);
  const Outcome o = run("0.trace 1.trace");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find("1.trace breaks off at tick"), std::string::npos) << o.out;
}

// A peer that has not got into the session leaves one.
TEST_F(Program, AnEmptyTraceIsLeftOutBesideOthers) {
  write("empty", {});
  const Outcome o = run("0.trace empty 1.trace");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err, "padr-report: empty: is empty: left out\n");
  EXPECT_NE(o.out.find("Confirmed worlds: identical"), std::string::npos) << o.out;
}

TEST_F(Program, WhatIsWrongIsOneClearLine) {
  test::RunConfig other;
  other.seed = 2;
  write_run("other", other);
  other.seed = 1;
  other.peers = 3;
  write_run("three", other);
  write("empty", {});
  std::ofstream(dir_ / "text") << "t,x,y\n";
  fs::copy_file(dir_ / "0.trace", dir_ / "copy.trace");
  fs::copy_file(dir_ / "0.trace", dir_ / "broken.trace");
  {
    std::fstream f(dir_ / "broken.trace", std::ios::in | std::ios::out | std::ios::binary);
    f.seekp(static_cast<std::streamoff>(fs::file_size(dir_ / "broken.trace") / 2));
    f << std::string(64, '\xFF');
  }
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "TRACE is required"},
      {"missing.trace", "cannot read 'missing.trace': No such file or directory"},
      {".", "cannot read '.': it is a directory"},
      {"empty", "empty: is empty, not a trace"},
      {"text", "text: not a trace of padr"},
      {"0.trace broken.trace", "broken.trace: is a trace of peer 0, and so is 0.trace"},
      {"broken.trace", "broken.trace: record "},
      {"0.trace 0.trace", "0.trace: is a trace of peer 0, and so is 0.trace"},
      {"0.trace copy.trace", "copy.trace: is a trace of peer 0, and so is 0.trace"},
      {"0.trace other1.trace", "other1.trace: is of another session than 0.trace: the scenario differs"},
      {"0.trace three1.trace", "three1.trace: is of another session than 0.trace: the number of peers differs"},
      {"0.trace --jsn -", "--jsn"},
      {"0.trace --json", "--json"},
      {"0.trace --json missing/j.json", "--json: cannot write 'missing/j.json'"},
      {"0.trace --csv text", "--csv: cannot make 'text'"},
      {"0.trace --plots text/below", "--plots: cannot make 'text/below'"},
  };
  for (const auto& [words, expected] : cases) {
    const Outcome o = run(words);
    EXPECT_EQ(o.status, 2) << words;
    EXPECT_NE(o.err.find(expected), std::string::npos) << words << ": " << o.err;
    EXPECT_EQ(o.err.rfind("padr-report: ", 0), 0U) << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << words << ": " << o.err;
  }
}

TEST_F(Program, HelpAndVersion) {
  const Outcome help = run("--help");
  EXPECT_EQ(help.status, 0);
  for (const char* expected : {"--json", "--csv", "--plots", "Examples:", "Exit code", "5 mm"})
    EXPECT_NE(help.out.find(expected), std::string::npos) << expected;
  EXPECT_EQ(run("--version").status, 0);
}

}  // namespace
}  // namespace padr
