#include "common/model/technique.h"

#include <gtest/gtest.h>

#include "common/model/user_error.h"

namespace padr {
namespace {

TEST(Technique, ThePapersThreeAreAppliedOnArrivalAndFirstOrder) {
  for (const char* name : {"avatar-only", "fixed", "adaptive"}) {
    const Technique t = technique_by_name(name);
    EXPECT_FALSE(t.replay) << name;
    EXPECT_EQ(t.model, Model::kFirst) << name;
    EXPECT_EQ(t.body_threshold, 0) << name;
  }
  EXPECT_FALSE(technique_by_name("avatar-only").authority);
  EXPECT_EQ(technique_by_name("fixed").predictor, Predictor::kNone);
  EXPECT_EQ(technique_by_name("adaptive").threshold_high, 0.8F);
  EXPECT_EQ(technique_by_name("adaptive").threshold_low, 0.3F);
  EXPECT_TRUE(technique_by_name("full").replay);
}

TEST(Technique, WhatOthersAreMeasuredAgainstIsToldToTheBit) {
  for (const auto name : technique_names())
    EXPECT_EQ(technique_by_name(name).precision, name == "full" ? Precision::kRounded : Precision::kExact) << name;
}

std::string message_of(void (*set)(Technique&, std::string_view), std::string_view text) {
  Technique t;
  try {
    set(t, text);
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

TEST(Technique, KnobsSayWhatIsAllowed) {
  EXPECT_EQ(message_of(set_threshold, "0.8:0.3"), "");
  EXPECT_EQ(message_of(set_threshold, "0.5"), "");
  EXPECT_NE(message_of(set_threshold, "0.3:0.8").find("HIGH >= LOW"), std::string::npos);
  for (const char* bad : {"", "x", "-1", "0", "0.5m", "nan", "inf", "1:", ":1", "0.8:0.3:0.1", "101"}) {
    const std::string m = message_of(set_threshold, bad);
    EXPECT_NE(m.find("--threshold"), std::string::npos) << bad;
    EXPECT_NE(m.find(std::string("'") + bad + "'"), std::string::npos) << m;
  }
  EXPECT_EQ(message_of(set_body_threshold, "off"), "");
  EXPECT_NE(message_of(set_body_threshold, "on").find("or off"), std::string::npos);
  EXPECT_NE(message_of(set_model, "third").find("static, first, second, input"), std::string::npos);
  EXPECT_NE(message_of(set_predictor, "magic").find("path-density"), std::string::npos);
  EXPECT_NE(message_of(set_law, "3").find("continuous"), std::string::npos);
  EXPECT_NE(message_of(set_convergence, "jump").find("pvb"), std::string::npos);
  EXPECT_EQ(message_of(set_precision, "exact"), "");
  EXPECT_NE(message_of(set_precision, "16").find("exact, rounded"), std::string::npos);
  EXPECT_EQ(message_of(set_unowned, "live"), "");
  EXPECT_NE(message_of(set_unowned, "mine").find("live, agreed"), std::string::npos);
  EXPECT_NE(message_of(set_time_stamps, "1").find("on, off"), std::string::npos);
  EXPECT_NE(message_of(set_replay, "yes").find("on, off"), std::string::npos);
  EXPECT_NE(message_of(set_steps, "0").find("1 to 600"), std::string::npos);
  EXPECT_NE(message_of(set_count, "1.5").find("bodies"), std::string::npos);
  EXPECT_NE(message_of(set_radius, "1e9").find("metres"), std::string::npos);
  EXPECT_THROW(technique_by_name("fulll"), UserError);
}

TEST(Technique, DescribedKnobsReadBack) {
  Technique t = technique_by_name("full");
  set_threshold(t, "0.3:0.1");
  EXPECT_EQ(
      describe(t),
      "full --threshold 0.3:0.1 --body-threshold 0.1 --replay on --model input --lead 0.1 --time-space 0.04 "
      "--predictor lookahead --threshold-law two-level --convergence pvb --radius 3 --precision rounded --unowned "
      "agreed --steps 30 --count 4 --pcc-bound 0.1");
  set_unowned(t, "live");
  set_time_stamps(t, "on");
  EXPECT_NE(describe(t).find(" --unowned live --time-stamps on "), std::string::npos);
}

}  // namespace
}  // namespace padr
