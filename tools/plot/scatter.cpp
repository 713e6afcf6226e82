#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shell/text.h"
#include "tools/plot/labels.h"
#include "tools/plot/layout.h"
#include "tools/plot/plot.h"
#include "tools/plot/svg.h"

namespace padr::plot {
namespace {

std::string block_of(const MarkSeries& series) {
  std::string s;
  for (const Mark& m : series.marks)
    s +=
        shell::csv_field(series.title) + "," + shell::csv_field(m.label) + "," + number(m.x) + "," + number(m.y) + "\n";
  return s;
}

std::string points_style(const Look& look) {
  return " with points pt " + std::to_string(look.point) + " ps 1.3*mark lw 1.8 lc rgb " + in_quotes(look.colour);
}

std::string curves_of(const MarkSeries& series, const std::string& from) {
  std::string s;
  if (series.joined) s += ", " + from + " using 3:4 with lines" + line_style(series.look, 1.2) + " notitle";
  return s + ", " + from + " using 3:4" + points_style(series.look) + " notitle";
}

/// What is drawn first: wide filled marks, so that others on the same place can still be seen.
int layer(int point) {
  constexpr std::array<int, 6> kFilled{5, 7, 15, 9, 11, 13};  // square, circle, pentagon, triangles, diamond
  const auto* const at = std::find(kFilled.begin(), kFilled.end(), point);
  return static_cast<int>(at - kFilled.begin());
}

/// For letters on white: as the mark, so that one sees whose they are.
std::string darker(std::string_view colour) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string s = "#";
  for (std::size_t i = 1; i < colour.size(); i += 2) {
    const int part = std::stoi(std::string(colour.substr(i, 2)), nullptr, 16) * 3 / 5;
    s += {kDigits[static_cast<std::size_t>(part / 16)], kDigits[static_cast<std::size_t>(part % 16)]};
  }
  return s;
}

/// Room around the points: factors on a logarithmic axis, shares of what the points span on another one.
struct Room {
  double above = 0;        ///< logarithmic
  double share_below = 0;  ///< linear
  double share_above = 0;
};

/// With both ends, because labels are placed by them; of a logarithmic axis gnuplot by itself goes to the next powers
/// of ten. As it is if there are no points.
Axis fitted(Axis a, const ScatterPlot& p, double Mark::*value, const Room& room) {
  double low = std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::lowest();
  for (const MarkSeries& s : p.series) {
    for (const Mark& m : s.marks) {
      if (!std::isfinite(m.*value) || (a.log && !(m.*value > 0))) continue;
      low = std::min(low, m.*value);
      high = std::max(high, m.*value);
    }
  }
  if (high < low) return a;
  if (a.log) {
    a.from = a.from.value_or(low / 1.5);
    a.to = a.to.value_or(high * room.above);
    return a;
  }
  const double least = std::max(std::abs(high) * 0.1, 1e-9);  // an axis has a length
  const double span = std::max(high - a.from.value_or(low), least);
  a.from = a.from.value_or(low - span * room.share_below);
  a.to = a.to.value_or(high + span * room.share_above);
  return a;
}

/// The plotting area: where a mark is in it.
class Ground {
 public:
  Ground(Axis x, Axis y, double width, double height)
      : x_(std::move(x)), y_(std::move(y)), width_(width), height_(height) {}

  bool known() const { return x_.from && x_.to && y_.from && y_.to; }
  bool shows(const Mark& m) const {
    return known() && std::isfinite(m.x) && std::isfinite(m.y) && within(x_, m.x) && within(y_, m.y);
  }
  /// Points from its upper left corner.
  Point at(const Mark& m) const { return {share(x_, m.x) * width_, (1 - share(y_, m.y)) * height_}; }
  /// As gnuplot takes it, in shares of the area.
  std::string graph(Point p) const { return "graph " + number(p.x / width_, 5) + "," + number(1 - p.y / height_, 5); }
  Obstacles nothing() const { return {.width = width_, .height = height_}; }

 private:
  static bool within(const Axis& a, double v) { return v >= *a.from && v <= *a.to && (!a.log || v > 0); }
  static double scaled(const Axis& a, double v) { return a.log ? std::log10(v) : a.root ? std::sqrt(v) : v; }
  static double share(const Axis& a, double v) {
    return (scaled(a, v) - scaled(a, *a.from)) / (scaled(a, *a.to) - scaled(a, *a.from));
  }

  Axis x_, y_;
  double width_, height_;
};

struct NamedPoint {
  Point at;
  std::string label;
  std::string_view colour;
};

/// Points of a series that lie on one another have one label, "6, 12".
std::vector<NamedPoint> named_points(const MarkSeries& series, const Ground& ground) {
  constexpr double kOneAnother = 4;  // points
  std::vector<NamedPoint> all;
  for (const Mark& m : series.marks) {
    if (m.label.empty() || !ground.shows(m)) continue;
    const Point at = ground.at(m);
    const auto there = std::find_if(all.begin(), all.end(), [at](const NamedPoint& n) {
      return std::hypot(n.at.x - at.x, n.at.y - at.y) < kOneAnother;
    });
    if (there == all.end()) {
      all.push_back({at, m.label, series.look.colour});
    } else {
      there->label += ", " + m.label;
    }
  }
  return all;
}

Obstacles obstacles_of(const ScatterPlot& p, const Ground& ground) {
  Obstacles o = ground.nothing();
  for (const MarkSeries& s : p.series) {
    const Mark* before = nullptr;
    for (const Mark& m : s.marks) {
      if (!ground.shows(m)) continue;
      o.marks.push_back(ground.at(m));
      if (s.joined && before != nullptr) o.lines.emplace_back(ground.at(*before), ground.at(m));
      before = &m;
    }
  }
  return o;
}

/// Commands for the labels, and for lines from those that had to go farther away.
std::string labels_of(const ScatterPlot& p, const Ground& ground) {
  const double size = p.canvas.font * 0.8;
  std::vector<NamedPoint> named;
  for (const MarkSeries& s : p.series)
    for (NamedPoint& n : named_points(s, ground)) named.push_back(std::move(n));
  std::vector<LabelRequest> requests;
  requests.reserve(named.size());
  // Most letters are digits, which are wider than others.
  for (const NamedPoint& n : named) requests.push_back({n.at, 1.12 * text_width(n.label, size), 1.15 * size});
  const std::vector<LabelPlace> places = place_labels(requests, obstacles_of(p, ground));
  std::string s = "unset arrow\n";
  for (std::size_t i = 0; i < places.size(); ++i) {
    const NamedPoint& n = named[i];
    Point at = places[i].centre;
    const double half = requests[i].width / 2;
    // The width is an estimate: letters begin, or end, where the label is nearest to its point.
    std::string_view anchor = "center";
    if (at.x - half > n.at.x) {
      anchor = "left";
      at.x -= half;
    } else if (at.x + half < n.at.x) {
      anchor = "right";
      at.x += half;
    }
    if (places[i].apart)
      s += "set arrow from " + ground.graph(n.at) + " to " + ground.graph(places[i].line_end) +
           " nohead back lw 0.8 lc rgb " + in_quotes(n.colour) + "\n";
    // Label 1 is the title.
    s += "set label " + std::to_string(i + 2) + " " + in_quotes(n.label) + " at " + ground.graph(at) + " " +
         std::string(anchor) + " noenhanced font 'sans," + number(size, 3) + "' tc rgb " + in_quotes(darker(n.colour)) +
         " front\n";
  }
  return s;
}

}  // namespace

std::vector<NamedText> files(const ScatterPlot& p) {
  const Canvas& c = p.canvas;
  const Rows rows(c);
  std::vector<std::string> titles;
  for (const MarkSeries& s : p.series) titles.push_back(s.title);
  const Key key = key_of(titles, c);
  const int top = rows.title(p.title) + rows.line() * key.rows + rows.line() / 2;

  const int height = c.height - top - rows.foot();
  std::string body = area(c, top, height) + heading(p.title, key);
  // To the right there are labels.
  const Axis x = fitted(p.x, p, &Mark::x, {2.5, 0.02, 0.1});
  const Axis y = fitted(p.y, p, &Mark::y, {1.5, 0.02, 0.05});
  body += axis('x', x) + axis('y', y) + labels_of(p, Ground(x, y, c.width - left_margin(c) - right_margin(c), height));
  std::string curves = "plot NaN notitle";
  std::string data = "title,label,x,y\n";
  std::vector<std::pair<int, std::string>> layers;
  for (const MarkSeries& s : p.series) {
    if (s.marks.empty()) continue;
    if (!layers.empty()) data += "\n\n";
    data += block_of(s);
    // The key has the order of the series, whatever is drawn first.
    curves += ", NaN" + points_style(s.look) + title_clause(s.title);
    const std::string from = in_quotes(p.name + ".csv") + " index " + std::to_string(layers.size());
    layers.emplace_back(layer(s.look.point), curves_of(s, from));
  }
  std::stable_sort(layers.begin(), layers.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [at, curve] : layers) curves += curve;
  return {{p.name + ".csv", data}, script(p.name, c, body + curves + "\n", "comma")};
}

}  // namespace padr::plot
