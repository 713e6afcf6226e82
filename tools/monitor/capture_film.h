#pragma once

#include <string>
#include <vector>

#include "tools/capture/setting.h"
#include "tools/monitor/film.h"
#include "tools/monitor/trace_film.h"

namespace padr::monitor {

/// Rebuilds the agreed world of a session from packet captures and films it: one view, of nobody in particular. Throws
/// UserError. `keylogs`: for encrypted ones, as padr-peer writes them.
Film film_captures(const std::vector<std::string>& files, const std::vector<std::string>& keylogs,
                   const capture::SettingFlags& flags, const Note& note);

}  // namespace padr::monitor
