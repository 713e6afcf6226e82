#include <array>
#include <cmath>

#include "tools/lab/figures/pictures.h"

namespace padr::lab::figures {
namespace {

using plot::in_quotes;
using plot::number;

constexpr int kCorners = 28;           // of what stands for a circle
constexpr std::size_t kEveryTick = 3;  // of the path; 20 a second are a smooth line
constexpr double kPi = 3.14159265358979;

/// The outline, closed, as rows of CSV, with an empty line after it.
std::string outline(const char* kind, const BodyDef& d, Vec2 at, float angle) {
  std::vector<Vec2> corners;
  if (d.shape == ShapeKind::kCircle) {
    for (int i = 0; i <= kCorners; ++i) {
      const auto a = static_cast<float>(2 * kPi * i / kCorners);
      corners.push_back(Vec2{std::cos(a), std::sin(a)} * d.radius);
    }
  } else {
    for (const Vec2 c : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}, Vec2{-1, -1}}) {
      const Vec2 p{c.x * d.half.x, c.y * d.half.y};
      corners.push_back({p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle)});
    }
  }
  std::string s;
  for (const Vec2 c : corners)
    s += std::string(kind) + "," + number(static_cast<double>(at.x + c.x), 5) + "," +
         number(static_cast<double>(at.y + c.y), 5) + "\n";
  return s + "\n";
}

std::string row(const char* kind, Vec2 at) {
  return std::string(kind) + "," + number(static_cast<double>(at.x), 5) + "," + number(static_cast<double>(at.y), 5) +
         "\n";
}

/// Blocks: bodies at the start, bodies at the end, obstacles, path, contacts, start and end of the path.
std::string table(const Case& c, const FigureRun& run) {
  std::string s = "kind,x_m,y_m\n";
  for (const BodyDef& d : c.scene.bodies) s += outline("body at the start", d, d.position, d.angle);
  s += "\n";
  for (std::size_t b = 0; b < run.bodies_end.size(); ++b)
    s += outline("body at the end", c.scene.bodies[b], run.bodies_end[b].position, run.bodies_end[b].angle);
  s += "\n";
  for (const BodyDef& d : c.scene.statics) s += outline("fixed", d, d.position, d.angle);
  // gnuplot does not count an empty block.
  s += "fixed,?,?\n\n\n";
  for (std::size_t t = 0; t < run.path.size(); t += kEveryTick) s += row("path", run.path[t]);
  s += "\n\n";
  for (std::size_t t = 0; t < run.touching.size(); ++t)
    if (run.touching[t] && (t == 0 || !run.touching[t - 1])) s += row("contact begins", run.path[t]);
  s += "contact begins,?,?\n\n\n" + row("start", run.path.front()) + "\n\n" + row("end", run.path.back());
  return s;
}

}  // namespace

std::vector<plot::NamedText> path_picture(const Case& c, const FigureRun& run) {
  const std::string name = "figure6-" + c.id;
  const Scene& scene = c.scene;
  const double width = static_cast<double>(scene.upper.x - scene.lower.x);
  const double height = static_cast<double>(scene.upper.y - scene.lower.y);
  const plot::Canvas canvas{900, std::max(300, static_cast<int>(760 * height / width) + 150), 17};
  const auto range = [](float low, float high) {
    return "[" + number(static_cast<double>(low)) + ":" + number(static_cast<double>(high)) + "]\n";
  };
  std::string s = "set title " + in_quotes("The avatar's path among the bodies: " + c.title) + " noenhanced\n";
  s += "set size ratio -1\nset xlabel 'x (m)'\nset ylabel 'y (m)'\nunset grid\nset border 15\n";
  s += "set xrange " + range(scene.lower.x, scene.upper.x) + "set yrange " + range(scene.lower.y, scene.upper.y);
  s += "set bmargin 6\nset key at screen 0.5, screen 0.01 center bottom horizontal Left reverse noenhanced samplen 1.6 "
       "maxcols 3\n";
  const auto block = [&name](int i) {
    return ", " + in_quotes(name + ".csv") + " index " + std::to_string(i) + " using 2:3 ";
  };
  s += "plot NaN notitle";
  s += block(0) + "with filledcurves closed fs solid 1 noborder lc rgb " + in_quotes(plot::shade(3)) +
       " title 'bodies at the start'";
  if (!scene.statics.empty())
    s += block(2) + "with filledcurves closed fs solid 1 noborder lc rgb " + in_quotes(plot::shade(2)) + " notitle";
  s += block(1) + "with lines lw 1.4 lc rgb " + in_quotes(plot::shade(1)) + " title 'bodies at the end'";
  s += block(3) + "with lines lw 1.2 lc rgb " + in_quotes(plot::shade(0)) + " title 'path of the avatar'";
  s += block(4) + "with points pt 7 ps 0.7*mark lc rgb " + in_quotes(plot::shade(0)) + " title 'begins to touch'";
  s += block(5) + "with points pt 6 ps 1.8*mark lw 2.5 lc rgb " + in_quotes(plot::shade(0)) + " title 'start'";
  s += block(6) + "with points pt 4 ps 1.8*mark lw 2.5 lc rgb " + in_quotes(plot::shade(0)) + " title 'end'\n";
  return {{name + ".csv", table(c, run)}, plot::script(name, canvas, s, "comma")};
}

}  // namespace padr::lab::figures
