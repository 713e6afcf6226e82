#pragma once

#include <string>
#include <vector>

#include "tools/lab/audit/audit.h"

namespace padr::lab::audit {

/// For people: a paragraph for each member with findings, at most `worst` lines of a kind.
std::string text(const Report& report, int worst);
/// Everything: docs/data.md.
std::string json(const Report& report, const std::vector<std::string>& command);

}  // namespace padr::lab::audit
