#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "shell/text.h"
#include "tools/plot/layout.h"
#include "tools/plot/plot.h"

namespace padr::plot {
namespace {

std::string block_of(const MarkSeries& series) {
  std::string s;
  for (const Mark& m : series.marks)
    s +=
        shell::csv_field(series.title) + "," + shell::csv_field(m.label) + "," + number(m.x) + "," + number(m.y) + "\n";
  return s;
}

std::string curves_of(const MarkSeries& series, const std::string& from, const Canvas& c) {
  std::string s;
  const std::string line = line_style(series.look, 1.2);
  if (series.joined) s += ", " + from + " using 3:4 with lines" + line + " notitle";
  s += ", " + from + " using 3:4 with points pt " + std::to_string(series.look.point) + " ps 1.3*mark lw 1.8 lc rgb " +
       in_quotes(series.look.colour) + title_clause(series.title);
  s += ", " + from + " using 3:4:2 with labels left offset character 0.8,0.5 noenhanced font 'sans," +
       std::to_string(c.font * 4 / 5) + "' tc rgb '#333333' notitle";
  return s;
}

/// With room around the points: gnuplot by itself goes to the next powers of ten.
Axis fitted(Axis a, const ScatterPlot& p, double Mark::*value, double room) {
  if (!a.log) return a;
  double low = std::numeric_limits<double>::max();
  double high = 0;
  for (const MarkSeries& s : p.series) {
    for (const Mark& m : s.marks) {
      if (!(m.*value > 0) || !std::isfinite(m.*value)) continue;
      low = std::min(low, m.*value);
      high = std::max(high, m.*value);
    }
  }
  if (high == 0) return a;
  a.from = a.from.value_or(low / 1.5);
  a.to = a.to.value_or(high * room);
  return a;
}

}  // namespace

std::vector<NamedText> files(const ScatterPlot& p) {
  const Canvas& c = p.canvas;
  const Rows rows(c);
  std::vector<std::string> titles;
  for (const MarkSeries& s : p.series) titles.push_back(s.title);
  const Key key = key_of(titles, c);
  const int top = rows.title(p.title) + rows.line() * key.rows + rows.line() / 2;

  std::string body = area(c, top, c.height - top - rows.foot()) + heading(p.title, key);
  // To the right there are labels.
  body += axis('x', fitted(p.x, p, &Mark::x, 2.5)) + axis('y', fitted(p.y, p, &Mark::y, 1.5));
  if (!p.x.log && !p.y.log) body += "set offsets graph 0.02, graph 0.1, graph 0.05, graph 0.02\n";
  std::string curves = "plot NaN notitle";
  std::string data = "title,label,x,y\n";
  int block = 0;
  for (const MarkSeries& s : p.series) {
    if (s.marks.empty()) continue;
    if (block > 0) data += "\n\n";
    data += block_of(s);
    curves += curves_of(s, in_quotes(p.name + ".csv") + " index " + std::to_string(block++), c);
  }
  return {{p.name + ".csv", data}, script(p.name, c, body + curves + "\n", "comma")};
}

}  // namespace padr::plot
