#pragma once

#include <string>

#include "common/session/session_event.h"

namespace padr::shell {

/// What happened, in one line for people.
std::string words_of(const node::SessionEvent& event);
/// Whether it is worth a warning.
bool is_problem(const node::SessionEvent& event);

}  // namespace padr::shell
