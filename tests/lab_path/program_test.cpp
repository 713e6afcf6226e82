// Paths as a user meets them: padr-lab path, and what is said of a path when it is loaded.
#include <algorithm>
#include <cmath>

#include "common/scenarios/path.h"
#include "common/scenarios/scenarios.h"
#include "shell/path_csv.h"
#include "shell/path_survey.h"
#include "tests/shell.h"

namespace padr {
namespace {

class PathProgram : public test::Shell {
 protected:
  test::Outcome lab(const std::string& words) const { return shell(std::string("'") + PADR_LAB + "' " + words); }
  /// A circle with a pointer in a window of 1200 by 800, logged every 8 ms.
  void write_mouse() const {
    std::string text = "t,x,y\n";
    for (int i = 0; i < 1000; ++i)
      text += std::to_string(1000 + 8 * i) + "," + std::to_string(600 + std::lround(400 * std::cos(i / 200.0))) + "," +
              std::to_string(400 + std::lround(300 * std::sin(i / 200.0))) + "\n";
    write("mouse.csv", text);
  }
};

TEST_F(PathProgram, ThePathOfAMouseIsWarnedOfAndThenFits) {
  write_mouse();
  const std::string run = "run --peers 1 --seconds 0.5 --input path:";
  const test::Outcome raw = lab(run + "mouse.csv");
  EXPECT_EQ(raw.status, 0) << raw.err;
  EXPECT_NE(raw.err.find("padr-lab: path mouse.csv: 1000 points in 7992 s, x 200 .. 1000 m"), std::string::npos)
      << raw.err;
  EXPECT_NE(raw.err.find("padr-lab: warning: path mouse.csv: 1000 of its 1000 points are outside the world"),
            std::string::npos)
      << raw.err;
  const test::Outcome fitted = lab("path --in mouse.csv --units px,ms --scenario arena --out fit.csv");
  EXPECT_EQ(fitted.status, 0) << fitted.err;
  EXPECT_EQ(fitted.err.find("warning"), std::string::npos) << fitted.err;
  const scenarios::Path path = shell::parse_path_csv(read("fit.csv"), "fit.csv");
  EXPECT_NEAR(path.duration(), 7.992, 1e-6);
  EXPECT_EQ(path.points().front().seconds, 0);
  EXPECT_TRUE(read("fit.csv").starts_with("# ")) << "it says how it was made";
  EXPECT_EQ(lab(run + "fit.csv").err.find("warning"), std::string::npos);
}

TEST_F(PathProgram, APathThatIsTooFastCanBeStretched) {
  write("fast.csv", "0,0,0\n100,1000,0\n200,0,0\n2000,0,500\n");
  EXPECT_NE(lab("path --in fast.csv --units px,ms --out a.csv").err.find("more than an avatar can do"),
            std::string::npos);
  const test::Outcome slow = lab("path --in fast.csv --units px,ms --stretch 40 --out b.csv");
  EXPECT_EQ(slow.err.find("warning"), std::string::npos) << slow.err;
  EXPECT_NEAR(shell::parse_path_csv(read("b.csv"), "b.csv").duration(), 80, 1e-6);
}

TEST_F(PathProgram, APeerSaysItToo) {
  write_mouse();
  const test::Outcome o = shell(std::string("'") + PADR_PEER +
                                "' --wait-peers 1 --duration 0.1 --listen 127.0.0.1:0 --input path:mouse.csv");
  EXPECT_EQ(o.status, 0) << o.err;
  const std::string all = o.out + o.err;
  EXPECT_NE(all.find("points are outside the world"), std::string::npos) << all;
  EXPECT_NE(all.find("path mouse.csv: 1000 points in"), std::string::npos) << all;
}

TEST_F(PathProgram, SaysWhatIsWrong) {
  write("one.csv", "0,1,2\n");
  write("still.csv", "0,1,2\n5,1,2\n");
  for (const auto& [words, expected] : std::vector<std::pair<std::string, std::string>>{
           {"--out -", "path: give one of --in and --input"},
           {"--in one.csv", "--out is required"},
           {"--in none.csv --out -", "--in: cannot read 'none.csv'"},
           {"--in one.csv --out -", "--in: one.csv:2:1: the file ends after 1 row,"},
           {"--in still.csv --units px,ms --out -", "--in: still.csv: all points are in one place"},
           {"--in still.csv --units ms,px --out -", "--units: 'ms,px' is not allowed; give px,ms or"},
           {"--in still.csv --input wander --out -", "excludes"},
           {"--input path:still.csv --out -", "is a path already; give it with --in"},
           {"--units px,ms --input wander --out -", "--units"},
           {"--input wander --scenario nowhere --out -", "--scenario: 'nowhere' is neither a file nor one of"}}) {
    const test::Outcome o = lab("path " + words);
    EXPECT_EQ(o.status, 2) << words;
    EXPECT_NE(o.err.find(expected), std::string::npos) << words << ": " << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  }
}

// The path that comes along is what its first line says, and fits its scenario.
TEST_F(PathProgram, TheSamplePathIsWhatItsRecipeMakes) {
  const test::Outcome o = lab("path --input wander:7 --scenario arena --seconds 20 --rate 20 --out made.csv");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.err.find("warning"), std::string::npos) << o.err;
  const std::string name = std::string("cat '") + SAMPLE_PATH + "'";
  const scenarios::Path sample = shell::parse_path_csv(shell(name).out, "sample");
  const scenarios::Path made = shell::parse_path_csv(read("made.csv"), "made.csv");
  ASSERT_EQ(sample.points().size(), made.points().size());
  for (std::size_t i = 0; i < made.points().size(); ++i) {
    EXPECT_EQ(sample.points()[i].seconds, made.points()[i].seconds);
    EXPECT_NEAR(sample.points()[i].position.x, made.points()[i].position.x, 0.0011);
    EXPECT_NEAR(sample.points()[i].position.y, made.points()[i].position.y, 0.0011);
  }
}

}  // namespace
}  // namespace padr
