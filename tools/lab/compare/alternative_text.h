#pragma once

#include <optional>
#include <string>

#include "tools/lab/alternatives/spec.h"

namespace padr::lab::compare {

/// An alternative with its knobs as one text, such as "rollback --input-delay 2 --hz 20". Nothing if the first word is
/// none of rollback, lockstep, snapshot, state-sync and dis. Throws UserError that names the knob, the value and what
/// is allowed.
std::optional<alternatives::Spec> alternative_of(const std::string& text);

/// Which knobs each takes, for help texts.
std::string help_on_alternatives();

}  // namespace padr::lab::compare
