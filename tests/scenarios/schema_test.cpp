#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <string>

#include "proto/scenario.pb.h"

namespace padr::scenarios {
namespace {

namespace pb = google::protobuf;
using padr::scenario::Rule;

/// Every number has a range, its own or its parent's; every text and list has a limit; defaults obey their rules.
void expect_rules(const pb::Descriptor& type, const Rule& inherited) {
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& f = *type.field(i);
    const Rule rule = f.options().GetExtension(padr::scenario::rule);
    const Rule& range = rule.has_min() ? rule : inherited;
    EXPECT_EQ(rule.has_min(), rule.has_max()) << f.full_name();
    if (f.is_repeated() || f.cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING) {
      EXPECT_TRUE(rule.has_max_items()) << f.full_name();
    }
    if (f.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) expect_rules(*f.message_type(), rule);
    const bool number =
        f.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE || f.cpp_type() == pb::FieldDescriptor::CPPTYPE_UINT32;
    if (!number) continue;
    EXPECT_LT(range.min(), range.max()) << f.full_name();
    if (!f.has_default_value()) continue;
    const double value =
        f.cpp_type() == pb::FieldDescriptor::CPPTYPE_DOUBLE ? f.default_value_double() : f.default_value_uint32();
    EXPECT_TRUE(value >= range.min() && value <= range.max()) << f.full_name() << " = " << value;
  }
}

TEST(ScenarioSchema, EveryFieldHasItsRule) {
  expect_rules(*padr::scenario::Scenario::descriptor(), Rule{});
}

}  // namespace
}  // namespace padr::scenarios
