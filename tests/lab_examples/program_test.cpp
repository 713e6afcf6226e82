// padr-lab examples as a user meets it.
#include "tests/shell.h"

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
