#include "tools/plot/layout.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace padr::plot {
namespace {

/// Width of an entry of a key in points, by what gnuplot reckons with for SVG, its widest: every letter is wide.
int width_of(const std::string& text, int font) {
  return (static_cast<int>(text.size()) * 70 + 500) * font / 100;
}

std::string fraction(int part, int whole) {
  return number(static_cast<double>(part) / static_cast<double>(whole), 6);
}

}  // namespace

int left_margin(const Canvas& c) {
  return c.font * 15 / 2;
}

int right_margin(const Canvas& c) {
  return c.font * 3 / 2;
}

Key key_of(const std::vector<std::string>& titles, const Canvas& c) {
  int widest = 0;
  int entries = 0;
  for (const std::string& t : titles) {
    if (t.empty()) continue;
    widest = std::max(widest, width_of(t, c.font));
    ++entries;
  }
  if (entries == 0) return {};
  const int columns = std::clamp((c.width - left_margin(c) - right_margin(c)) / widest, 1, entries);
  return {(entries + columns - 1) / columns, columns};
}

std::string area(const Canvas& c, int top, int height) {
  return "set lmargin at screen " + fraction(left_margin(c), c.width) + "\nset rmargin at screen " +
         fraction(c.width - right_margin(c), c.width) + "\nset tmargin at screen " +
         fraction(c.height - top, c.height) + "\nset bmargin at screen " + fraction(c.height - top - height, c.height) +
         "\n";
}

std::string heading(const std::string& title, const Key& key) {
  std::string s = "unset label\n";
  if (!title.empty())
    s += "set label 1 " + in_quotes(title) + " at graph 0, graph 1 left noenhanced offset character 0," +
         number(0.9 + key.rows, 4) + "\n";
  if (key.rows == 0) return s + "unset key\n";
  return s + "set key at graph 0, graph 1.01 left bottom horizontal Left reverse noenhanced samplen 1.6 maxcols " +
         std::to_string(key.columns) + "\n";
}

namespace {

/// Values of a square-root axis that leave room for one another.
std::string root_ticks(double to) {
  constexpr double kApart = 0.09;  // of the height
  std::string s;
  double last = -1;
  for (const double v :
       {0.0, 0.1, 0.3, 0.5, 0.8, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 20.0, 30.0, 50.0, 70.0, 100.0, 200.0}) {
    const double at = std::sqrt(v / to);
    if (at > 1 || (last >= 0 && at - last < kApart)) continue;
    s += (s.empty() ? "" : ", ") + number(v);
    last = at;
  }
  return s;
}

}  // namespace

std::string axis(char name, const Axis& a) {
  const std::string n(1, name);
  const auto end = [](const std::optional<double>& v) { return v ? number(*v) : std::string("*"); };
  std::string s = "set " + n + "label " + in_quotes(a.label) + " noenhanced\n";
  // A logarithmic axis is a nonlinear one to gnuplot, so that goes before.
  s += "unset nonlinear " + n + "\n" + (a.log ? "set logscale " : "unset logscale ") + n + "\n";
  if (a.root && a.to)
    s += "set nonlinear " + n + " via sqrt(" + n + ") inverse " + n + "*" + n + "\nset " + n + "tics (" +
         root_ticks(*a.to) + ")\n";
  else
    s += "set " + n + "tics autofreq\n";
  return s + "set " + n + "range [" + end(a.from) + ":" + end(a.to) + "]\n";
}

std::string line_style(const Look& look, double width) {
  constexpr std::array<std::string_view, 5> kDashes{"1", "(12,5)", "(2,4)", "(12,4,2,4)", "(6,4)"};
  return " lw " + number(width, 3) + " lc rgb " + in_quotes(look.colour) + " dt " +
         std::string(kDashes[static_cast<std::size_t>(look.dash) % kDashes.size()]);
}

std::string title_clause(const std::string& title) {
  return title.empty() ? " notitle" : " title " + in_quotes(title);
}

}  // namespace padr::plot
