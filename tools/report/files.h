#pragma once

#include <string>
#include <string_view>

#include "tools/report/analysis.h"

namespace padr::report {

/// Throws UserError if the file cannot be read.
TraceBytes read_trace(const std::string& file);
/// `flag` is for messages. Throws UserError, on a full disk std::system_error.
void write_file(std::string_view flag, const std::string& file, const std::string& text);

}  // namespace padr::report
