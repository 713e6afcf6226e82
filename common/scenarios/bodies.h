#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace padr::scenarios {

/// The scenario in `text` as it would be with `bodies` bodies in all: the same text with another count in its last
/// `scatter` block or, if it has none, in its last `row`. Throws UserError, which begins with `label`, if there is no
/// such block, or fewer bodies are wanted than the rest of the file has. Whether there is room is for `load` to say.
std::string with_bodies(std::string_view text, std::string_view label, std::uint32_t bodies);

}  // namespace padr::scenarios
