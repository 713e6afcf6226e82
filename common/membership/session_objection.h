#pragma once

#include <string>

#include "common/membership/session_state.h"

namespace padr::node {

/// Why a newcomer does not fit the session of these; empty if it does.
std::string objection(const SessionConfig& session, const wire::Join& join);

}  // namespace padr::node
