#pragma once

#include <string>

#include "tools/monitor/observed_sessions.h"
#include "tools/monitor/web_server.h"

namespace padr::monitor {

/// In the text format of Prometheus 0.0.4: base units, counters end in _total. `session` and `web` may be null.
std::string metrics_text(const ObservedSession* session, const HeardStats& heard, const WebStats* web, Micros now);

}  // namespace padr::monitor
