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

TEST(Technique, AWrongNameIsRefused) {
  EXPECT_THROW(technique_by_name("fulll"), UserError);
}

}  // namespace
}  // namespace padr
