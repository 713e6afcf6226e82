#include "tools/lab/benchmark/benchmark.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/model/user_error.h"
#include "shell/files.h"
#include "shell/netem_text.h"
#include "tools/lab/alternatives/replica.h"
#include "tools/lab/benchmark/material.h"
#include "tools/lab/benchmark/page.h"
#include "tools/lab/compare/fields.h"

namespace padr::lab::benchmark {
namespace {

compare::Plan small_plan() {
  compare::Plan p;
  p.contestants = compare::chosen_contestants("full,rollback-2");
  p.setting.ticks = 2 * kTicksPerSecond;
  p.networks = {{"delay 50ms", shell::parse_netem("delay 50ms", nullptr)}};
  p.seeds = {1, 2};
  p.parallel.quiet = true;
  return p;
}

/// A folder of this test's own, empty.
std::string fresh_folder(const std::string& name) {
  const std::string dir = testing::TempDir() + "/padr_benchmark_" + name;
  std::filesystem::remove_all(dir);
  std::filesystem::create_directories(dir);
  return dir;
}

void write(const std::string& path, const std::string& text) {
  shell::OutputFile file("", path);
  file.write(text);
  file.close();
}

/// The rows without processor time, which differs from run to run.
std::string deterministic(const std::string& csv) {
  std::string out;
  for (std::size_t from = 0; from < csv.size();) {
    const std::size_t to = csv.find('\n', from);
    const std::string line = csv.substr(from, to - from);
    out += line.substr(0, line.rfind(',')) + "\n";
    from = to + 1;
  }
  return out;
}

template <typename Act>
std::string error_of(const Act& act) {
  try {
    act();
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(Benchmark, GoesOnWhereItWasStopped) {
  const std::string file = fresh_folder("resume") + "/results.csv";
  const Benchmark b(small_plan());
  ASSERT_EQ(b.size(), 4U);
  EXPECT_EQ(b.run(file).done_now, 4U);
  const std::string whole = shell::read_file("", file);
  // Killed in the middle of the third row.
  std::size_t end = 0;
  for (int line = 0; line < 3; ++line) end = whole.find('\n', end) + 1;
  write(file, whole.substr(0, end + 40));
  EXPECT_NE(error_of([&] { b.rows(file); }).find("has 2 of 4 runs"), std::string::npos);
  EXPECT_EQ(b.run(file).done_now, 2U);
  EXPECT_EQ(deterministic(shell::read_file("", file)), deterministic(whole));
  EXPECT_TRUE(shell::read_file("", file).starts_with(whole.substr(0, end))) << "what was done is not done again";
  EXPECT_EQ(b.run(file).done_now, 0U);
}

TEST(Benchmark, RowsAreThoseOfACompare) {
  const std::string file = fresh_folder("rows") + "/results.csv";
  const Benchmark b(small_plan());
  b.run(file);
  const std::vector<compare::Row> read = b.rows(file);
  const std::vector<compare::Row> played = compare::run_plan(small_plan());
  ASSERT_EQ(read.size(), played.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].who.id, played[i].who.id);
    EXPECT_EQ(read[i].network, played[i].network);
    ASSERT_EQ(read[i].scores.size(), 2U);
    EXPECT_GT(read[i].processor_steps().value_or(0), 0);
    for (std::size_t s = 0; s < 2; ++s)
      for (const compare::Field& f : compare::fields())
        EXPECT_NEAR(f.of(read[i].scores[s]), f.of(played[i].scores[s]), 1e-5 * std::abs(f.of(played[i].scores[s])))
            << f.name;
  }
}

TEST(Benchmark, RefusesWhatIsNotItsOwn) {
  const std::string file = fresh_folder("other") + "/results.csv";
  const Benchmark b(small_plan());
  b.run(file);
  compare::Plan longer = small_plan();
  longer.setting.ticks += 1;
  const Benchmark other(longer);
  EXPECT_NE(other.id(), b.id());
  EXPECT_NE(error_of([&] { other.run(file); }).find("--out: " + file + ":2: is of grid " + b.id()), std::string::npos);
  std::string text = shell::read_file("", file);
  text.replace(text.rfind(','), 1, ",x");
  write(file, text);
  EXPECT_NE(error_of([&] { b.rows(file); }).find(file + ":5: 'x"), std::string::npos);
}

TEST(Benchmark, IdIsOfAllThatResultsDependOn) {
  const std::string id = Benchmark(small_plan()).id();
  EXPECT_EQ(Benchmark(small_plan()).id(), id);
  std::vector<compare::Plan> others(5, small_plan());
  others[0].setting.scenario = "clutter";
  others[1].setting.peers = 3;
  others[2].seeds = {2, 1};
  others[3].contestants[1] = compare::added_contestant("rollback --input-delay 2 --prediction 9");
  others[3].contestants[1].id = "rollback-2";
  others[4].networks = {{"trace mobile", shell::parse_netem("trace mobile", nullptr)}};
  for (const compare::Plan& p : others) EXPECT_NE(Benchmark(p).id(), id);
}

/// A contestant that tells nothing.
class Mute final : public alternatives::Replica {
 public:
  Mute(const Scene& scene, const alternatives::AlternativeConfig& config) : Replica(scene, config) {}

 protected:
  bool take(PeerId, alternatives::BitReader&) override { return false; }
  void place_others() override {}
  void send() override {}
};

// Once, who changed a contestant's file and built it was shown the figures of before: the revision is the same then.
TEST(Benchmark, IdIsOfWhatTheCodeOfAContestantDoes) {
  const auto id_with = [](alternatives::Maker make) {
    compare::Plan p = small_plan();
    p.contestants = compare::chosen_contestants("positions");
    if (make != nullptr) std::get<alternatives::Spec>(p.contestants[0].how).make = make;
    return Benchmark(p).id();
  };
  EXPECT_EQ(id_with(nullptr), id_with(nullptr));
  EXPECT_NE(id_with(nullptr),
            id_with([](const Scene& scene,
                       const alternatives::AlternativeConfig& config) -> std::unique_ptr<alternatives::Alternative> {
              return std::make_unique<Mute>(scene, config);
            }));
}

TEST(Benchmark, GivesOthersItsInputsAndLinks) {
  const std::string dir = fresh_folder("material");
  compare::Plan p = small_plan();
  p.networks = {{"trace mobile", shell::parse_netem("trace mobile", nullptr)}};
  write_material(p, dir);
  const std::string path = shell::read_file("", dir + "/inputs/seed2-peer3.csv");
  EXPECT_TRUE(path.starts_with("# wander, seed 2, peer 3, scenario arena\nt,x,y\n")) << path.substr(0, 80);
  EXPECT_EQ(std::count(path.begin(), path.end(), '\n'), 2 + p.setting.ticks + 1);
  EXPECT_GT(shell::read_file("", dir + "/links/mobile.link").size(), 1000U);
}

TEST(Benchmark, ThePageShowsWhereARivalHasLess) {
  const auto row = [](const char* id, double m, double kbps) {
    compare::Row r;
    r.who = compare::chosen_contestants(id).front();
    r.network = "delay 50ms";
    r.scores.emplace_back();
    r.scores.back().off.mean_m = m;
    r.scores.back().kbps = kbps;
    return r;
  };
  const compare::Plan p = small_plan();
  const std::string wins = "<td class=\"wins\">";
  EXPECT_NE(page({row("full", 0.1, 30), row("dis", 0.05, 31)}, p, "padr-lab", "id").find(wins + "0.050"),
            std::string::npos);
  for (const compare::Row& loser : {row("dis", 0.2, 31), row("dis", 0.05, 29)})
    EXPECT_EQ(page({row("full", 0.1, 30), loser}, p, "padr-lab", "id").find(wins), std::string::npos);
}

TEST(Fields, AreReadAsTheyWereWritten) {
  compare::Score s;
  double v = 1;
  for (const compare::Field& f : compare::fields()) f.put(s, v++);
  v = 1;
  for (const compare::Field& f : compare::fields()) EXPECT_EQ(f.of(s), v++) << f.name;
}

}  // namespace
}  // namespace padr::lab::benchmark
