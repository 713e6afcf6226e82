#pragma once

#include <string>
#include <vector>

#include "tools/lab/figures/experiment.h"
#include "tools/plot/plot.h"

namespace padr::lab::figures {

/// Data and scripts of all pictures into `dir`, then the pictures. Returns what went wrong in one line, empty if
/// nothing did; data and scripts are there in any case.
std::string draw_pictures(const std::string& dir, const Plan& plan, const Results& results,
                          const ParallelOptions& parallel);

/// The avatar's path among the bodies (the paper's Figure 6): figure6-CASE.csv and .gp.
std::vector<plot::NamedText> path_picture(const Case& c, const FigureRun& run);
// The others as data.
plot::LinePlot figure7(const Plan& plan, const Results& results, std::size_t of_case);
plot::LinePlot figure8(const Plan& plan, const Results& results, std::size_t of_case);
plot::LinePlot figure9(const Plan& plan, const Results& results, std::size_t of_case);
/// All cases together: mean and range over time, on a logarithmic scale.
plot::LinePlot drift(const Plan& plan, const Results& results);
/// What peaks cost in updates.
plot::ScatterPlot peaks(const Plan& plan, const Results& results);
/// Precision and recall by predictor.
plot::BarPlot predictors(const Plan& plan, const Results& results);

}  // namespace padr::lab::figures
