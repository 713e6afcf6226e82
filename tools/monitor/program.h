#pragma once

#include "tools/monitor/options.h"

namespace padr::monitor {

/// Until a signal or the end of --duration; the exit code. Throws UserError or std::system_error.
int run(const Options& options);

}  // namespace padr::monitor
