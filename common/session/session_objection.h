#pragma once

#include <string>

#include "common/session/session_state.h"

namespace padr::node {

/// Why a joiner does not fit the session; empty if it does.
std::string objection(const SessionConfig& session, const wire::Join& join);

}  // namespace padr::node
