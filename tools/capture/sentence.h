#pragma once

#include <string>

#include "tools/capture/input.h"
#include "tools/capture/record.h"

namespace padr::capture {

/// A datagram in one line, for people: "peer 1 -> 0: tick 812, 2 updates (threshold, contact_begin), 3 bodies, ...".
std::string sentence(const Record& r);

}  // namespace padr::capture
