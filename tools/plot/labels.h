#pragma once

#include <utility>
#include <vector>

#include "tools/plot/plot.h"

// Where the labels of a picture's points go. Lengths are points of the canvas, y downwards, from the upper left corner
// of the plotting area.
namespace padr::plot {

struct LabelRequest {
  Point of;           ///< the point that it names
  double width = 0;   ///< > 0
  double height = 0;  ///< > 0
};

struct LabelPlace {
  Point centre;
  bool apart = false;  ///< too far from its point to be read as its label: draw a line from the one to the other
  Point line_end;      ///< of that line, at the label's edge
};

/// What labels keep clear of, the points that they name included.
struct Obstacles {
  double width = 0;  ///< of the plotting area
  double height = 0;
  std::vector<Point> marks = {};
  std::vector<std::pair<Point, Point>> lines = {};  ///< crossed if there is no better place
};

/// A place for each label, in the order of the requests, as near to its point as the others allow: no two overlap
/// unless there are too many for the area. The same request has the same answer everywhere.
std::vector<LabelPlace> place_labels(const std::vector<LabelRequest>& labels, const Obstacles& obstacles);

}  // namespace padr::plot
