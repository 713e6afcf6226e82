#include <algorithm>
#include <string>
#include <vector>

#include "shell/text.h"
#include "tools/plot/layout.h"
#include "tools/plot/plot.h"

namespace padr::plot {
namespace {

constexpr int kPanelHeight = 190;   // points, of the plotting area of one of several
constexpr int kSingleHeight = 340;  // of the only one

// The data are one table, in blocks that gnuplot tells apart by two empty lines. Each block is a line, a spread or a
// shading.
class Table {
 public:
  /// The number of the new block.
  std::string begin(const std::string& panel, const std::string& kind, const std::string& title) {
    if (block_ >= 0) text_ += "\n\n";
    prefix_ = shell::csv_field(panel) + "," + kind + "," + shell::csv_field(title) + ",";
    return std::to_string(++block_);
  }
  void row(double x, const std::string& y, const std::string& y2) {
    text_ += prefix_ + number(x) + "," + y + "," + y2 + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_ = "panel,kind,title,x,y,y2\n";
  std::string prefix_;
  int block_ = -1;
};

Key key_of(const Panel& panel, const Canvas& c) {
  std::vector<std::string> titles;
  for (const Shading& s : panel.shadings) titles.push_back(s.title);
  for (const Spread& s : panel.spreads) titles.push_back(s.title);
  for (const Line& l : panel.lines) titles.push_back(l.title);
  return plot::key_of(titles, c);
}

/// Rectangles, as only they reach the graph's own edges whatever the range of y is.
std::string rectangles(const Panel& panel, Table& table) {
  std::string s = "unset object\n";
  for (const Shading& shading : panel.shadings) {
    if (shading.stretches.empty()) continue;
    table.begin(panel.title, "from-until", shading.title);
    for (const Shading::Stretch& t : shading.stretches) {
      table.row(t.from, number(t.to), "");
      s += "set object rectangle from " + number(t.from) + ", graph 0 to " + number(t.to) + ", graph 1 behind fc rgb " +
           in_quotes(shading.colour) + " fs solid 1 noborder\n";
    }
  }
  return s;
}

/// What is drawn first lies below.
std::string curves(const Panel& panel, const std::string& data, Table& table) {
  std::string s = "plot NaN notitle";
  for (const Shading& shading : panel.shadings)
    if (!shading.title.empty())
      s += ", NaN with boxes fs solid 1 noborder lc rgb " + in_quotes(shading.colour) + title_clause(shading.title);
  for (const Spread& spread : panel.spreads) {
    if (spread.slices.empty()) continue;
    s += ", " + in_quotes(data) + " index " + table.begin(panel.title, "low-high", spread.title) +
         " using 4:5:6 with filledcurves fs transparent solid 0.3 noborder lc rgb " + in_quotes(spread.look.colour) +
         title_clause(spread.title);
    for (const Spread::Slice& v : spread.slices) table.row(v.x, number(v.low), number(v.high));
  }
  for (const Line& line : panel.lines) {
    if (line.points.empty()) continue;
    s += ", " + in_quotes(data) + " index " + table.begin(panel.title, "line", line.title) + " using 4:5 with " +
         (line.steps ? "steps" : "lines") + line_style(line.look, line.width) + title_clause(line.title);
    for (const Point& v : line.points) table.row(v.x, number(v.y), "");
  }
  return s + "\n";
}

}  // namespace

std::vector<NamedText> files(const LinePlot& p) {
  Canvas canvas = p.canvas;
  const Rows rows(canvas);
  std::vector<int> heads;
  int used = rows.title(p.title) + rows.foot();
  for (const Panel& panel : p.panels) {
    heads.push_back(rows.line() * (key_of(panel, canvas).rows + (panel.title.empty() ? 0 : 1)) + rows.line());
    used += heads.back();
  }
  const auto panels = std::max(1, static_cast<int>(p.panels.size()));
  if (canvas.height == 0) canvas.height = used + (panels == 1 ? kSingleHeight : panels * kPanelHeight);
  const int height = std::max(40, (canvas.height - used) / panels);

  Table table;
  std::string body = "set multiplot" + (p.title.empty() ? "" : " title " + in_quotes(p.title) + " noenhanced") + "\n";
  int top = rows.title(p.title);
  for (std::size_t i = 0; i < p.panels.size(); ++i) {
    const Panel& panel = p.panels[i];
    top += heads[i];
    Axis x = p.x;
    const bool last = i + 1 == p.panels.size();
    if (!last) x.label.clear();
    body += area(canvas, top, height) + heading(panel.title, key_of(panel, canvas));
    body += axis('x', x) + (last ? "set format x\n" : "set format x ''\n") + axis('y', panel.y);
    body += rectangles(panel, table) + curves(panel, p.name + ".csv", table);
    top += height;
  }
  body += "unset multiplot\n";
  return {{p.name + ".csv", table.text()}, script(p.name, canvas, body, "comma")};
}

}  // namespace padr::plot
