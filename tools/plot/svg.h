#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/plot/plot.h"

namespace padr::plot {

/// How a shape is painted; colours as "#RRGGBB" or "none".
struct Paint {
  std::string_view fill = "none";
  std::string_view stroke = "none";
  double width = 1;              ///< of the stroke, points
  std::string_view dashes = "";  ///< lengths in points, such as "4 2"; empty: solid
  double opacity = 1;
};

enum class Anchor { kStart, kMiddle, kEnd };

struct Lettering {
  double size = 14;  ///< points
  std::string_view colour = "#000000";
  Anchor anchor = Anchor::kStart;
  bool bold = false;
};

/// Writes one SVG picture (SVG 1.1) of simple shapes, in points, y downwards. The same calls give the same text.
class Svg {
 public:
  Svg(double width, double height);

  void rect(double x, double y, double width, double height, const Paint& paint);
  void circle(Point centre, double radius, const Paint& paint);
  void polygon(const std::vector<Point>& corners, const Paint& paint);
  void line(const std::vector<Point>& points, const Paint& paint);
  void text(double x, double y, std::string_view words, const Lettering& lettering);
  /// What comes until end_window() is cut off at this rectangle; coordinates stay those of the picture.
  void begin_window(double x, double y, double width, double height);
  void end_window();

  /// The finished picture.
  std::string text() const { return out_ + "</svg>\n"; }

 private:
  void points(std::string_view element, const std::vector<Point>& list, const Paint& paint);
  std::string out_;
};

/// How wide words are about, points: enough to place things beside them.
double text_width(std::string_view words, double size);

/// Makes NAME.png of NAME.svg in `dir` for every name, by rsvg-convert, twice as large. Returns what went wrong in one
/// line, such as that it is not installed and which package has it; empty if nothing did.
std::string rasterize(const std::string& dir, const std::vector<std::string>& names);

}  // namespace padr::plot
