#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/wire/membership_codec.h"
#include "common/wire/seal.h"
#include "common/wire/session_codec.h"

namespace padr::capture {

/// As proto/WIRE.md, section 1, calls them; empty for kNone.
std::string_view name_of(wire::SealError why);
std::string_view name_of(wire::Kind kind);
/// In lower case: join, welcome, ...
std::string_view name_of(const wire::SessionMessage& message);
std::string_view name_of(const wire::MembershipMessage& message);

}  // namespace padr::capture
