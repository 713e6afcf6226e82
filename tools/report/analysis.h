#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/report/report.h"
#include "tools/report/survey.h"

namespace padr::report {

/// Aligns the traces of one session's peers on the session tick and measures. Who came late, vanished or came back has
/// a trace of each of its incarnations. Throws UserError if a trace is damaged, if they are not of one session, each of
/// another incarnation, or if none of them was ever a part of it.
Report analyse(const std::vector<TraceBytes>& traces);

}  // namespace padr::report
