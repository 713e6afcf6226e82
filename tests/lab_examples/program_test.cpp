// padr-lab examples as a user meets it.
#include "shell/path_csv.h"
#include "tests/shell.h"
#include "tools/lab/examples/story.h"

namespace padr {
namespace {

class Examples : public test::Shell {
 protected:
  test::Outcome examples(const std::string& words) const {
    return shell(std::string("'") + PADR_LAB + "' examples " + words);
  }
};

TEST_F(Examples, WriteTheSameFilesHoweverManyRunAtOnce) {
  for (const char* jobs : {"1", "3"}) {
    const auto r = examples("--out here --stories ball,proxy --takes 2 --no-pictures --jobs " + std::string(jobs));
    ASSERT_EQ(r.status, 0) << r.err;
    shell("cp here/takes.csv takes" + std::string(jobs) + " && cp here/examples.csv means" + jobs + " && cp out table" +
          jobs);
  }
  EXPECT_EQ(read("takes1"), read("takes3"));
  EXPECT_EQ(read("means1"), read("means3"));
  EXPECT_GT(read("takes1").size(), 2U * 14 * 60);
}

// tools/demo.sh and the test with real peers play the stories from these files.
TEST_F(Examples, WriteThePathsThatComeWithTheScenarios) {
  for (const std::string story : {"ball", "dominoes", "van", "proxy"}) {
    ASSERT_EQ(shell("cp '" PADR_PATHS "/" + story + ".csv' was").status, 0);
    EXPECT_EQ(read("was"), shell::write_path_csv(lab::examples::path_of(lab::examples::story_by_name(story), 0)))
        << "padr-lab examples --out DIR writes DIR/path-" << story << ".csv anew";
  }
}

TEST_F(Examples, TellEachPredictorsWorthAndWriteThePathOnFilm) {
  ASSERT_EQ(examples("--out here --stories ball --takes 1 --no-pictures").status, 0);
  EXPECT_NE(read("out").find("\n  lookahead: It steps a copy from the avatar's true state"), std::string::npos);
  EXPECT_EQ(read("here/predictors.csv").find("story,predictor,takes,warned,"), 0U);
  EXPECT_NE(read("here/summary.json").find("\"avoided_m\""), std::string::npos);
  EXPECT_EQ(read("here/path-ball.csv").find("t,x,y\n"), 0U);
}

TEST_F(Examples, SayWhatTheyWereAskedInTheSummary) {
  ASSERT_EQ(examples("--out here --stories van --takes 1 --no-pictures --json -").status, 0);
  EXPECT_EQ(read("out"), read("here/summary.json"));
  EXPECT_NE(read("out").find("\"command\": "), std::string::npos);
  EXPECT_NE(read("out").find("--stories van --takes 1"), std::string::npos);
}

TEST_F(Examples, RefuseWhatIsWrongInOneLine) {
  const auto refused = [this](const std::string& words, const std::string& flag) {
    const auto r = examples(words);
    EXPECT_EQ(r.status, 2) << words;
    EXPECT_NE(r.err.find(flag), std::string::npos) << r.err;
    EXPECT_EQ(r.err.find('\n'), r.err.size() - 1) << r.err;
  };
  refused("--out here --stories ball,cube", "--stories: 'cube'");
  refused("--out here --takes 0", "--takes");
  refused("--out here --netem 'delay x'", "--netem");
  refused("", "--out");
  write("file", "");
  refused("--out file/x --stories van --takes 1", "--out");
}

}  // namespace
}  // namespace padr
