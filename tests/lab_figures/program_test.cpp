// padr-lab figures as a user meets it.
#include <algorithm>
#include <string>

#include "tests/shell.h"

namespace padr {
namespace {

class FiguresProgram : public test::Shell {
 protected:
  test::Outcome figures(const std::string& words, const std::string& before = "") const {
    return shell(before + " '" + std::string(PADR_LAB) + "' figures " + words);
  }
  bool there(const std::string& name) const { return !read(name).empty(); }
};

TEST_F(FiguresProgram, DataArePictureAndPageAndTheSameBytesAgain) {
  const std::string words = " --seeds 2 --seconds 6 --scenario arena --seed 3";
  const test::Outcome first = figures("--out a --jobs 1" + words);
  const test::Outcome second = figures("--out b --jobs 4 --no-pictures" + words);
  ASSERT_EQ(first.status, 0) << first.err;
  ASSERT_EQ(second.status, 0) << second.err;
  for (const char* name :
       {"summary.json", "runs.csv", "predictors.csv", "series-wander-3.csv", "series-wander-4.csv"}) {
    EXPECT_GT(read(std::string("a/") + name).size(), 300U) << name;
    EXPECT_EQ(read(std::string("a/") + name), read(std::string("b/") + name)) << name;
  }
  for (const char* name :
       {"figure6-wander-3", "figure7-wander-3", "figure8-wander-4", "figure9-wander-4", "drift", "peaks", "prediction"})
    for (const char* kind : {".svg", ".png", ".csv", ".gp"})
      EXPECT_TRUE(there(std::string("a/") + name + kind)) << name << kind;
  EXPECT_FALSE(there("b/drift.svg"));
  EXPECT_NE(first.out.find("Figure 7: grows-without-authority"), std::string::npos) << first.out;
}

TEST_F(FiguresProgram, ThePageNeedsNothingElse) {
  ASSERT_EQ(figures("--out a --seeds 1 --seconds 3").status, 0);
  const std::string page = read("a/report.html");
  const auto count = [&page](const std::string& words) {
    std::size_t n = 0;
    for (std::size_t at = page.find(words); at != std::string::npos; at = page.find(words, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<svg"), 7U);
  EXPECT_EQ(count("<svg role=\"img\" aria-label=\""), 7U);
  EXPECT_EQ(count(" id='drift-gpDot'"), 1U);
  EXPECT_EQ(count(" id='gpDot'"), 0U) << "each drawing has one";
  EXPECT_EQ(count("<table"), 4U);
  EXPECT_EQ(count("<div class=\"wide\" tabindex=\"0\"><table"), 4U) << "scrolls by itself in a narrow window";
  for (const char* outside : {"<img", "<script", "<link", "src=", "href=\"http", "url(http", "@import", "<?xml"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
}

TEST_F(FiguresProgram, WarnsWhereLittleWasConfirmedInTime) {
  const test::Outcome o = figures("--out a --seeds 1 --seconds 6 --no-pictures --netem 'delay 8s'");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.err.find("padr-lab: warning: full 0.8:0.3 m: inconsistency was measured at the first "),
            std::string::npos)
      << o.err;
  EXPECT_EQ(figures("--out b --seeds 1 --seconds 3 --no-pictures").err, "");
}

TEST_F(FiguresProgram, RecordedPathsAndALoopByThem) {
  write("my path.csv", "t,x,y\n0,2,2\n1,8,6\n2,14,9\n3,4,11\n");
  const test::Outcome o =
      figures("--out a --seeds 1 --seconds 3 --no-pictures --input 'path:my path.csv,loop' --input rest");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(there("a/series-my-path-1.csv"));
  EXPECT_TRUE(there("a/series-rest-1.csv"));
}

/// What stands behind the key, to the end of its line, from `from` on.
std::string behind(const std::string& json, const std::string& key, std::size_t from = 0) {
  const std::size_t at = json.find("\"" + key + "\": ", from);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + key.size() + 4;
  return json.substr(begin, json.find_first_of(",\n", begin) - begin);
}

TEST_F(FiguresProgram, ARowsCommandGivesItsNumbersAgain) {
  ASSERT_EQ(figures("--out a --seeds 1 --seconds 8 --no-pictures --unowned agreed --add 'full --lead 0.2'").status, 0);
  const std::string all = read("a/summary.json");
  const std::size_t cases = all.find("\"cases\"");
  for (const char* id : {"fixed-0.5", "full---lead-0.2"}) {
    const std::size_t row = all.find("\"" + std::string(id) + "\": {", cases);
    ASSERT_NE(row, std::string::npos) << id;
    const std::string quoted = behind(all, "command", row);
    ASSERT_GT(quoted.size(), 20U);
    const std::string command = quoted.substr(1, quoted.size() - 2);
    EXPECT_EQ(command.rfind("padr-lab run ", 0), 0U) << command;
    const test::Outcome again = shell("'" + std::string(PADR_LAB) + "' " + command.substr(9) + " --json -");
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(behind(again.out, "mean_m"), behind(all, "mean_m", row)) << command;
    EXPECT_EQ(behind(again.out, "peak_m"), behind(all, "peak_m", row)) << command;
  }
}

TEST_F(FiguresProgram, MistakesAreOneLineAndNothingIsWritten) {
  for (const char* words : {"", "--out a --seconds 1", "--out a --seeds 0", "--out a --input path:none.csv",
                            "--out a --scenario nowhere", "--out a --netem 'delay x'", "--out a --jobs -1"}) {
    const test::Outcome o = figures(words);
    EXPECT_EQ(o.status, 2) << words;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_EQ(o.err.rfind("padr-lab: --", 0), 0U) << o.err;
    EXPECT_FALSE(std::filesystem::exists(path("a"))) << words;
  }
}

TEST_F(FiguresProgram, WithoutGnuplotTheDataStay) {
  std::filesystem::create_directories(path("empty"));
  const test::Outcome o = figures("--out a --seeds 1 --seconds 3", "PATH='" + path("empty") + "'");
  EXPECT_EQ(o.status, 1);
  EXPECT_NE(o.err.find("apt-get install gnuplot"), std::string::npos) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  for (const char* name : {"a/summary.json", "a/report.html", "a/drift.csv", "a/drift.gp"}) EXPECT_TRUE(there(name));
}

}  // namespace
}  // namespace padr
