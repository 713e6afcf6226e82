// Files of sweeps: the same bytes however they came about.
#include "tools/lab/sweep/sweep.h"

#include "shell/technique_text.h"
#include "tests/lab_sweep/error_of.h"
#include "tests/shell.h"

namespace padr::lab::sweep {
namespace {

using test::error_of;

class Sweep : public test::Shell {
 protected:
  static Grid grid(const std::string& seeds = "1-4") {
    GridText t;
    t.knobs.resize(shell::knobs().size());
    t.delay = "0,50ms";
    t.loss = "0,20%";
    t.bodies = "8";
    t.seeds = seeds;
    t.seconds = 0.5;
    return Grid(t);
  }
  SweepResult sweep(const std::string& file, const Shard& shard = {}, const std::string& seeds = "1-4",
                    int jobs = 2) const {
    ParallelOptions parallel;
    parallel.threads = jobs;
    parallel.quiet = true;
    return run_sweep(grid(seeds), shard, path(file), parallel);
  }
  std::string whole() const {
    sweep("whole");
    return read("whole");
  }
};

TEST_F(Sweep, OneRowForEveryRunInOrder) {
  const SweepResult r = sweep("a");
  EXPECT_EQ(r.runs, 16U);
  EXPECT_EQ(r.done_now, 16U);
  const std::string text = read("a");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 17);
  EXPECT_TRUE(text.starts_with("grid,run,of,scenario,bodies,peers,delay_ms,"));
  std::size_t at = 0;
  for (int run = 0; run < 16; ++run) {
    const std::size_t found = text.find("\n" + grid().id() + "," + std::to_string(run) + ",16,arena,8,2,", at);
    ASSERT_NE(found, std::string::npos) << run;
    at = found;
  }
}

TEST_F(Sweep, TheSameBytesHoweverManyRunAtOnce) {
  sweep("one", {}, "1-4", 1);
  sweep("four", {}, "1-4", 4);
  EXPECT_EQ(read("one"), read("four"));
}

TEST_F(Sweep, GoesOnWhereItWasCut) {
  const std::string all = whole();
  // In the heading, after it, in the midst of a row, at its last letter, between rows, at the end.
  const std::size_t heading = all.find('\n');
  const std::size_t second = all.find('\n', heading + 1);
  for (const std::size_t length : {std::size_t{0}, std::size_t{5}, heading, heading + 1, heading + 9, second,
                                   second + 1, all.size() / 2, all.size() - 1, all.size()}) {
    write("cut", all.substr(0, length));
    const SweepResult r = sweep("cut");
    EXPECT_EQ(read("cut"), all) << length;
    EXPECT_EQ(r.done_now,
              16 - static_cast<std::size_t>(std::max<std::ptrdiff_t>(
                       0, std::count(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(length), '\n') - 1)))
        << length;
  }
}

// Once, such a row counted as 0.
TEST_F(Sweep, AMeasureThatIsNoNumberIsRefused) {
  const std::string all = whole();
  const std::size_t row = all.find('\n') + 1;
  const std::size_t measure = all.find(",0.5,", row) + 5;  // behind the seconds
  write("damaged", all.substr(0, measure) + "abc" + all.substr(all.find(',', measure)));
  EXPECT_EQ(error_of([&] { sweep("damaged"); }),
            "--csv: " + path("damaged") + ":2: 'abc' in column mean_m is no number");
}

TEST_F(Sweep, RowsInAnyOrderAreTaken) {
  const std::string all = whole();
  const std::size_t heading = all.find('\n') + 1;
  const std::size_t second = all.find('\n', heading) + 1;
  write("mixed", all.substr(0, heading) + all.substr(second) + all.substr(heading, second - heading));
  EXPECT_EQ(sweep("mixed").done_now, 0U);
  EXPECT_EQ(read("mixed"), all);
}

TEST_F(Sweep, ShardsMergeIntoTheWhole) {
  const std::string all = whole();
  for (std::size_t i = 1; i <= 3; ++i) sweep("part" + std::to_string(i), {i, 3});
  EXPECT_EQ(merge({path("part2"), path("part3"), path("part1")}, path("merged")), 16U);
  EXPECT_EQ(read("merged"), all);
}

TEST_F(Sweep, MoreShardsThanRunsMergeToo) {
  const std::string all = whole();
  std::vector<std::string> parts;
  for (std::size_t i = 1; i <= 20; ++i) {
    sweep("part" + std::to_string(i), {i, 20});
    parts.push_back(path("part" + std::to_string(i)));
  }
  merge(parts, path("merged"));
  EXPECT_EQ(read("merged"), all);
}

TEST_F(Sweep, MergeRefusesWhatIsNoWhole) {
  for (std::size_t i = 1; i <= 2; ++i) sweep("part" + std::to_string(i), {i, 2});
  sweep("other", {2, 2}, "5-8");
  const auto refused = [this](const std::vector<std::string>& files) {
    std::vector<std::string> paths;
    for (const std::string& f : files) paths.push_back(path(f));
    const std::string message = error_of([&] { merge(paths, path("merged")); });
    EXPECT_FALSE(std::filesystem::exists(path("merged")));
    return message;
  };
  EXPECT_EQ(refused({"part1"}),
            "SHARD: runs 1, 3, 5, 7, 9 and 3 more of 16 missing: a shard is not here, or not complete");
  EXPECT_NE(refused({"part1", "part2", "part1"}).find("run 0 is in"), std::string::npos);
  EXPECT_NE(refused({"part1", "other"}).find("is of grid " + grid("5-8").id()), std::string::npos);
  const std::string part = read("part2");
  // Once, it counted all of these.
  std::string damaged = read("part1");
  for (std::size_t at = 0; (at = damaged.find(",16,arena", at)) != std::string::npos; ++at)
    damaged.replace(at, 4, ",99999999999,");
  write("damaged", damaged);
  EXPECT_EQ(
      refused({"damaged"}),
      "SHARD: runs 1, 3, 5, 7, 9 and 99999999986 more of 99999999999 missing: a shard is not here, or not complete");
  write("part2", part.substr(0, part.size() - 1));
  EXPECT_NE(refused({"part1", "part2"}).find("its end is cut off"), std::string::npos);
  write("part2", "t,x,y\n1,2,3\n");
  EXPECT_NE(refused({"part1", "part2"}).find("part2:1: is not the heading of a sweep"), std::string::npos);
  write("part2", part + "something else\n");
  EXPECT_NE(refused({"part1", "part2"}).find("part2:10: is not a row of a sweep"), std::string::npos);
}

// Once, the rows of one of the two were gone.
TEST_F(Sweep, TwoAtOnceDoNotWriteOneFile) {
  std::string second;
  Runs runs{"id", 2, "grid,run,of,seed", [](std::size_t run) { return "id," + std::to_string(run) + ",2,1"; }};
  Runs first = runs;
  first.row = [&](std::size_t run) {
    second = error_of([&] { run_missing(runs, {2, 2}, path("file"), {.quiet = true}); });
    return runs.row(run);
  };
  run_missing(first, {1, 2}, path("file"), {.quiet = true});
  EXPECT_EQ(second,
            "--csv: " + path("file") + ": another padr-lab is writing it; wait for its end, or give another file");
  EXPECT_EQ(read("file"), "grid,run,of,seed\nid,0,2,1\n");
  EXPECT_FALSE(std::filesystem::exists(path("file.lock")));
  write("file.lock", "");  // left behind
  EXPECT_EQ(run_missing(runs, {1, 2}, path("file"), {.quiet = true}).done_now, 0U);
}

TEST_F(Sweep, RowsOfOthersAreNotTouched) {
  sweep("file");
  const std::string before = read("file");
  EXPECT_NE(error_of([&] { sweep("file", {}, "1-5"); }).find("file:2: is of grid " + grid().id()), std::string::npos);
  EXPECT_NE(error_of([&] { sweep("file", {1, 2}); }).find("run 1 is not of shard 1/2"), std::string::npos);
  EXPECT_EQ(read("file"), before);
  for (const char* notes : {"my notes\n", "my notes"}) {
    write("file", notes);
    EXPECT_NE(error_of([&] { sweep("file"); }).find("file:1: is not the heading"), std::string::npos);
    EXPECT_EQ(read("file"), notes);
  }
}

}  // namespace
}  // namespace padr::lab::sweep
