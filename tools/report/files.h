#pragma once

#include <string>

#include "tools/report/analysis.h"

namespace padr::report {

/// Throws UserError if the file cannot be read.
TraceBytes read_trace(const std::string& file);

}  // namespace padr::report
