#pragma once

#include <string>
#include <vector>

#include "tools/lab/figures/claims.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab::figures {

/// For people, on a terminal.
std::string table(const Plan& plan, const Results& results, const std::vector<Claim>& claims);
/// Everything but the series. No clock in it: the same plan gives the same text.
std::string json(const Plan& plan, const Results& results, const std::vector<Claim>& claims);
/// runs.csv, predictors.csv, and one series-CASE.csv per case: every tick of every setting.
std::vector<plot::NamedText> csv_files(const Plan& plan, const Results& results);

}  // namespace padr::lab::figures
