#pragma once

#include "tools/report/report.h"

namespace padr::report {

/// Fills in groups, overall and notes from the peers, links and the check of a report.
void summarize(Report& r);

}  // namespace padr::report
