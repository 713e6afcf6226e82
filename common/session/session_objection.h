#pragma once

#include <string>
#include <string_view>

#include "common/session/session_state.h"

namespace padr::node {

/// How a refusal begins if all slots are taken. Whoever joins anew may have to leave its own.
inline constexpr std::string_view kFull = "the session is full";

/// Why a joiner does not fit the session; empty if it does.
std::string objection(const SessionConfig& session, const wire::Join& join);

/// That a member has welcomed this peer, and nobody has admitted it within that time, us. `why`: what became of that
/// member, if it is known.
std::string no_admission(const Endpoint& by, Micros within, const std::string& why = "");

/// For the texts of failures: "4 s", "0.5 s".
std::string in_seconds(Micros t);

}  // namespace padr::node
