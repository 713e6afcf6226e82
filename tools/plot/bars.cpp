#include <algorithm>
#include <string>
#include <vector>

#include "shell/text.h"
#include "tools/plot/layout.h"
#include "tools/plot/plot.h"

namespace padr::plot {
namespace {

constexpr double kGroupWidth = 0.8;  // of the distance between groups

}  // namespace

std::vector<NamedText> files(const BarPlot& p) {
  const Canvas& c = p.canvas;
  const Rows rows(c);
  std::vector<std::string> titles;
  for (const BarSeries& s : p.series) titles.push_back(s.title);
  const Key key = key_of(titles, c);
  const int top = rows.title(p.title) + rows.line() * key.rows + rows.line();

  std::string tics;
  for (std::size_t g = 0; g < p.groups.size(); ++g)
    tics += (g == 0 ? "" : ", ") + in_quotes(p.groups[g]) + " " + std::to_string(g);
  Axis y = p.y;
  if (!y.log && !y.from) y.from = 0;
  Axis x{.from = -0.6, .to = static_cast<double>(p.groups.size()) - 0.4};
  std::string body = area(c, top, c.height - top - rows.foot()) + heading(p.title, key) + axis('x', x) + axis('y', y) +
                     "set xtics (" + tics + ") noenhanced scale 0\nunset grid\nset grid ytics ls 100\n";
  if (p.label_digits > 0) body += "set offsets 0, 0, graph 0.06, 0\n";

  const double width = kGroupWidth / static_cast<double>(std::max<std::size_t>(1, p.series.size()));
  body += "set boxwidth " + number(width * 0.94) + " absolute\n";
  std::string curves = "plot NaN notitle";
  std::string data = "title,group,x,y\n";
  for (std::size_t i = 0; i < p.series.size(); ++i) {
    const BarSeries& s = p.series[i];
    if (i > 0) data += "\n\n";
    for (std::size_t g = 0; g < s.values.size() && g < p.groups.size(); ++g)
      data += shell::csv_field(s.title) + "," + shell::csv_field(p.groups[g]) + "," +
              number(static_cast<double>(g) + width * (static_cast<double>(i) + 0.5) - kGroupWidth / 2) + "," +
              number(s.values[g]) + "\n";
    const std::string from = ", " + in_quotes(p.name + ".csv") + " index " + std::to_string(i) + " using 3:4";
    curves += from + " with boxes fs solid 1 noborder lc rgb " + in_quotes(s.look.colour) + title_clause(s.title);
    if (p.label_digits > 0)
      curves += from + ":(sprintf('%." + std::to_string(p.label_digits) +
                "g',$4)) with labels offset character 0,0.5 font 'sans," + std::to_string(c.font * 3 / 4) +
                "' tc rgb '#333333' notitle";
  }
  return {{p.name + ".csv", data}, script(p.name, c, body + curves + "\n", "comma")};
}

}  // namespace padr::plot
