#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tools/plot/gnuplot.h"
#include "tools/plot/palette.h"

// Pictures as data: fill a plot in, files() makes NAME.csv and NAME.gp of it, write_into() and draw() (gnuplot.h) turn
// these into NAME.svg and NAME.png. Values that are not finite are gaps.
//
//   plot::LinePlot p{.name = "drift", .x = {.label = "session time (s)"}};
//   p.panels.push_back({.y = {.label = "combined inconsistency (m)"}});
//   p.panels[0].lines.push_back({.title = "full", .look = plot::look_of("full"), .points = series});
//   plot::write_into("--out", dir, plot::files(p));
//   const plot::Drawing d = plot::draw(dir, {p.name});   // d.wrong: empty, or one line for the user
namespace padr::plot {

struct Axis {
  std::string label = {};  ///< with its unit
  bool log = false;
  bool root = false;                ///< square roots: small values beside high peaks, and zero; begins at 0
  std::optional<double> from = {};  ///< where it begins, the data's beginning if not given
  std::optional<double> to = {};    ///< the data's end if not given; to be given for `root`
};

struct Point {
  double x = 0;
  double y = 0;
};

struct Line {
  std::string title = {};  ///< in the key; empty: not in the key
  Look look = {};
  std::vector<Point> points = {};
  bool steps = false;  ///< holds its value until the next point
  double width = 1.6;
};

/// The area between two curves, such as the range of several runs, in a paler tone.
struct Spread {
  struct Slice {
    double x = 0;
    double low = 0;
    double high = 0;
  };
  std::string title = {};
  Look look = {};
  std::vector<Slice> slices = {};
};

/// Stretches of the x axis that are shaded over the whole height.
struct Shading {
  struct Stretch {
    double from = 0;
    double to = 0;
  };
  std::string title = {};
  std::string_view colour = "#CCCCCC";
  std::vector<Stretch> stretches = {};
};

struct Panel {
  std::string title = {};
  Axis y = {};
  std::vector<Line> lines = {};
  std::vector<Spread> spreads = {};
  std::vector<Shading> shadings = {};
};

/// Curves over time or over a parameter; panels stand one above the other on the same x axis.
struct LinePlot {
  std::string name = {};  ///< of the files
  std::string title = {};
  Axis x = {};
  std::vector<Panel> panels = {};
  Canvas canvas{900, 0, 17};  ///< height 0: according to the number of panels
};

struct Mark {
  double x = 0;
  double y = 0;
  std::string label = {};  ///< beside the point; may be empty
};

/// One technique's points, in order.
struct MarkSeries {
  std::string title = {};
  Look look = {};
  std::vector<Mark> marks = {};
  bool joined = false;  ///< by a thin line, such as for one knob turned step by step
};

/// What is paid for what is got: labelled points by technique.
struct ScatterPlot {
  std::string name = {};
  std::string title = {};
  Axis x = {};
  Axis y = {};
  std::vector<MarkSeries> series = {};
  Canvas canvas{900, 560, 17};
};

struct BarSeries {
  std::string title = {};
  Look look = {};
  std::vector<double> values = {};  ///< by group; may be fewer
};

/// Groups of bars side by side.
struct BarPlot {
  std::string name = {};
  std::string title = {};
  Axis y = {};
  std::vector<std::string> groups = {};  ///< below the x axis
  std::vector<BarSeries> series = {};
  int label_digits = 3;  ///< significant digits of the values over the bars; 0: none
  Canvas canvas{900, 460, 17};
};

/// NAME.csv with a line of headings, and NAME.gp.
std::vector<NamedText> files(const LinePlot& p);
std::vector<NamedText> files(const ScatterPlot& p);
std::vector<NamedText> files(const BarPlot& p);

}  // namespace padr::plot
