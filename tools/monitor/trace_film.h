#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/monitor/film.h"

namespace padr::monitor {

/// Lines for the log.
using Note = std::function<void(const std::string&)>;

/// A trace in memory.
struct NamedTrace {
  std::string name;  ///< for messages
  std::string bytes;
};

/// Replays the traces of one session, one at least, through fresh nodes, side by side, and films what a monitor of
/// these peers would have been told. Throws UserError.
Film film_traces(std::vector<NamedTrace> traces, const Note& note);
/// The same of files, and of folders whose *.trace are meant.
Film film_traces(const std::vector<std::string>& paths, const Note& note);

}  // namespace padr::monitor
