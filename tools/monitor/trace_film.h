#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/monitor/film.h"

namespace padr::monitor {

/// Lines for the log.
using Note = std::function<void(const std::string&)>;

/// Replays the traces of one session through fresh nodes, side by side, and films what a monitor of these peers would
/// have been told. `paths`: traces, and folders whose *.trace are meant. Throws UserError.
Film film_traces(const std::vector<std::string>& paths, const Note& note);

}  // namespace padr::monitor
