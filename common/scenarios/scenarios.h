#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/model/scene.h"

namespace padr::scenarios {

/// The scenario in `text`, in the text format of proto/scenario.proto, with every number filled in: what is random in
/// it is drawn from `seed`. The same text and seed give the same scene. Throws UserError, one line
/// "label:line:column: field value, allowed: range", for anything wrong: syntax, a number that is missing, not finite
/// or out of range, a body outside the play area, things that overlap at the start, bodies for which there is no room.
Scene load(std::string_view text, std::string_view label, std::uint64_t seed);

/// Names of the scenarios that are built into the library, sorted.
std::vector<std::string_view> embedded_names();

/// Text of a built-in scenario. Throws UserError, which lists the names, for an unknown one.
std::string_view embedded_text(std::string_view name);

/// `load` of a built-in scenario, labelled `name.textproto`.
Scene load_embedded(std::string_view name, std::uint64_t seed);

}  // namespace padr::scenarios
