#include "shell/technique_text.h"

#include <gtest/gtest.h>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

/// What is wrong with a value of a knob; empty if nothing is.
std::string message_of(const std::string& flag, const std::string& value) {
  try {
    technique_of("full " + flag + "=" + value);
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(TechniqueText, KnobsSayWhatIsAllowed) {
  EXPECT_EQ(message_of("--threshold", "0.8:0.3"), "");
  EXPECT_EQ(message_of("--threshold", "0.5"), "");
  EXPECT_NE(message_of("--threshold", "0.3:0.8").find("HIGH >= LOW"), std::string::npos);
  for (const char* bad : {"", "x", "-1", "0", "0.5m", "nan", "inf", "1:", ":1", "0.8:0.3:0.1", "101"}) {
    const std::string m = message_of("--threshold", bad);
    EXPECT_NE(m.find("--threshold"), std::string::npos) << bad;
    EXPECT_NE(m.find(std::string("'") + bad + "'"), std::string::npos) << m;
  }
  EXPECT_EQ(message_of("--body-threshold", "off"), "");
  EXPECT_NE(message_of("--body-threshold", "on").find("or off"), std::string::npos);
  EXPECT_NE(message_of("--model", "third").find("static, first, second, input"), std::string::npos);
  EXPECT_NE(message_of("--predictor", "magic").find("path-density"), std::string::npos);
  EXPECT_NE(message_of("--threshold-law", "3").find("continuous"), std::string::npos);
  EXPECT_NE(message_of("--convergence", "jump").find("track"), std::string::npos);
  EXPECT_EQ(message_of("--precision", "exact"), "");
  EXPECT_NE(message_of("--precision", "16").find("exact, rounded"), std::string::npos);
  EXPECT_EQ(message_of("--unowned", "live"), "");
  EXPECT_NE(message_of("--unowned", "mine").find("live, agreed"), std::string::npos);
  EXPECT_NE(message_of("--time-stamps", "1").find("on, off"), std::string::npos);
  EXPECT_NE(message_of("--replay", "yes").find("on, off"), std::string::npos);
  EXPECT_NE(message_of("--steps", "0").find("1 to 600"), std::string::npos);
  EXPECT_NE(message_of("--count", "1.5").find("bodies"), std::string::npos);
  EXPECT_NE(message_of("--radius", "1e9").find("metres"), std::string::npos);
}

TEST(TechniqueText, DescribedKnobsReadBack) {
  EXPECT_EQ(
      describe(technique_of("full --threshold 0.3:0.1")),
      "full --threshold 0.3:0.1 --body-threshold 0.012 --replay on --model auto --lead 0.04 --foresee 0.1 --time-space "
      "0.04 --predictor lookahead --threshold-law two-level --convergence track --radius 3 --precision rounded "
      "--unowned "
      "agreed --budget 64 --steps 30 --count 4 --pcc-bound 0.1");
  EXPECT_NE(describe(technique_of("full --unowned live --time-stamps on")).find(" --unowned live --time-stamps on "),
            std::string::npos);
}

TEST(TechniqueText, WhatIsDescribedReadsBack) {
  for (const std::string_view name : technique_names())
    EXPECT_EQ(technique_of(describe(technique_by_name(name))), technique_by_name(name)) << name;
}

}  // namespace
}  // namespace padr::shell
