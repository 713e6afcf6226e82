#pragma once

#include <google/protobuf/text_format.h>

#include <functional>
#include <string>

#include "common/scenarios/document.h"

namespace padr::scenarios {

/// Walks every field of a parsed scenario against the `rule` that scenario.proto gives it: there if required, exactly
/// one of each oneof, finite, in range, not too many. `seen` hears where each given field stands; `fail`, which must
/// throw, hears of the first thing wrong.
void check_rules(const padr::scenario::Scenario& scenario, const google::protobuf::TextFormat::ParseInfoTree& tree,
                 const std::function<void(const Origin&)>& seen,
                 const std::function<void(const Origin&, const std::string&)>& fail);

}  // namespace padr::scenarios
