#pragma once

#include <string>
#include <vector>

#include "tools/lab/audit/evidence.h"
#include "tools/lab/audit/finding.h"

namespace padr::lab::audit {

/// Where members said two things with one number. What a member only passed on, without a valid signature in a session
/// with a key, is nobody's word.
std::vector<Finding> find_two_updates(const Evidence& evidence, const std::vector<std::string>& labels);

}  // namespace padr::lab::audit
