#include "tools/plot/svg.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "tools/plot/gnuplot.h"

namespace padr::plot {
namespace {

constexpr int kCannotRun = 127;

std::string escaped(std::string_view words) {
  std::string s;
  for (const char c : words) {
    if (c == '&') {
      s += "&amp;";
    } else if (c == '<') {
      s += "&lt;";
    } else {
      s += c;
    }
  }
  return s;
}

/// Hundredths of a point are finer than anything shows.
std::string rounded(double v) {
  return number(static_cast<double>(static_cast<long long>(v * 100 + (v < 0 ? -0.5 : 0.5))) / 100, 9);
}

std::string attribute(std::string_view name, std::string_view value) {
  return " " + std::string(name) + "=\"" + std::string(value) + "\"";
}

std::string attribute(std::string_view name, double value) {
  return attribute(name, rounded(value));
}

std::string attributes(const Paint& p) {
  std::string s = attribute("fill", p.fill);
  if (p.stroke != "none") s += attribute("stroke", p.stroke) + attribute("stroke-width", p.width);
  if (!p.dashes.empty()) s += attribute("stroke-dasharray", p.dashes);
  if (p.opacity < 1) s += attribute("opacity", p.opacity);
  return s;
}

int run_rsvg(const std::string& svg, const std::string& png) {
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) {
    execlp("rsvg-convert", "rsvg-convert", "--zoom", "2", "--background-color", "white", "--output", png.c_str(),
           svg.c_str(), static_cast<char*>(nullptr));
    _exit(kCannotRun);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "waitpid");
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

Svg::Svg(double width, double height) {
  out_ = R"(<svg xmlns="http://www.w3.org/2000/svg")" + attribute("width", width) + attribute("height", height) +
         attribute("viewBox", "0 0 " + rounded(width) + " " + rounded(height)) +
         attribute("font-family", "DejaVu Sans, Arial, sans-serif") + ">\n";
  rect(0, 0, width, height, {.fill = "#FFFFFF"});
}

void Svg::rect(double x, double y, double width, double height, const Paint& paint) {
  out_ += "<rect" + attribute("x", x) + attribute("y", y) + attribute("width", width) + attribute("height", height) +
          attributes(paint) + "/>\n";
}

void Svg::circle(Point centre, double radius, const Paint& paint) {
  out_ += "<circle" + attribute("cx", centre.x) + attribute("cy", centre.y) + attribute("r", radius) +
          attributes(paint) + "/>\n";
}

void Svg::points(std::string_view element, const std::vector<Point>& list, const Paint& paint) {
  std::string text;
  for (const Point& p : list) text += (text.empty() ? "" : " ") + rounded(p.x) + "," + rounded(p.y);
  out_ += "<" + std::string(element) + attribute("points", text) + attributes(paint) + "/>\n";
}

void Svg::polygon(const std::vector<Point>& corners, const Paint& paint) {
  points("polygon", corners, paint);
}

void Svg::line(const std::vector<Point>& list, const Paint& paint) {
  points("polyline", list, paint);
}

void Svg::text(double x, double y, std::string_view words, const Lettering& l) {
  out_ += "<text" + attribute("x", x) + attribute("y", y) + attribute("font-size", l.size);
  if (l.colour != "#000000") out_ += attribute("fill", l.colour);
  if (l.anchor != Anchor::kStart) out_ += attribute("text-anchor", l.anchor == Anchor::kMiddle ? "middle" : "end");
  if (l.bold) out_ += attribute("font-weight", "bold");
  out_ += ">" + escaped(words) + "</text>\n";
}

void Svg::begin_window(double x, double y, double width, double height) {
  out_ += "<svg" + attribute("x", x) + attribute("y", y) + attribute("width", width) + attribute("height", height) +
          attribute("viewBox", rounded(x) + " " + rounded(y) + " " + rounded(width) + " " + rounded(height)) + ">\n";
}

void Svg::end_window() {
  out_ += "</svg>\n";
}

double text_width(std::string_view words, double size) {
  std::size_t letters = 0;
  for (const char c : words) letters += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;  // UTF-8
  return 0.58 * size * static_cast<double>(letters);
}

std::string rasterize(const std::string& dir, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto base = std::filesystem::path(dir) / name;
    const int status = run_rsvg(base.string() + ".svg", base.string() + ".png");
    if (status == kCannotRun)
      return "no rsvg-convert, so pictures as SVG only: install it (sudo apt-get install librsvg2-bin)";
    if (status != 0) return "rsvg-convert failed on " + base.string() + ".svg";
  }
  return "";
}

}  // namespace padr::plot
