#pragma once

#include <string>
#include <vector>

#include "tools/plot/gnuplot.h"
#include "tools/report/report.h"

namespace padr::report {

/// For people: aligned, units in the headings.
std::string table(const Report& r);

/// Everything, with where it came from. `command`: this program's own.
std::string json(const Report& r, const std::vector<std::string>& command);

using plot::NamedText;

/// inconsistency.csv, fidelity.csv, traffic.csv, links.csv, authority.csv.
std::vector<NamedText> csv_files(const Report& r);

/// Data and one script for gnuplot per plot: NAME.dat, NAME.gp; the script, run in the files' folder, writes NAME.svg
/// and NAME.png.
std::vector<NamedText> plot_files(const Report& r);
/// Names of the plots in plot_files.
std::vector<std::string> plot_names();

}  // namespace padr::report
