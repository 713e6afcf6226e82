#include "tools/plot/film_strip.h"

#include <algorithm>
#include <cmath>

#include "tools/plot/svg.h"

namespace padr::plot {
namespace {

constexpr double kMargin = 16;
constexpr double kGap = 8;
constexpr double kLetters = 15;
constexpr double kLine = 24;

Paint paint_of(Role role) {
  switch (role) {
    case Role::kBody:
      return {.fill = "#BBBBBB", .stroke = "#333333"};
    case Role::kDisturbed:
      return {.fill = "#D55E00", .stroke = "#333333"};
    case Role::kAvatar:
      return {.fill = "#0072B2", .stroke = "#333333"};
    case Role::kModel:
      return {.fill = "#56B4E9", .stroke = "#333333"};
    case Role::kOutline:
      return {.stroke = "#000000", .width = 1.3, .dashes = "3 2"};
  }
  return {};
}

Paint paint_of(Role role, std::string_view colour) {
  Paint paint = paint_of(role);
  if (!colour.empty()) paint.fill = colour;
  return paint;
}

/// From metres, y upwards, to points of the picture, y downwards.
struct Lens {
  Vec2 lower, upper;    ///< m
  double x = 0, y = 0;  ///< of the upper left corner, points
  double scale = 1;     ///< points per metre

  Point at(Vec2 p) const {
    return {x + static_cast<double>(p.x - lower.x) * scale, y + static_cast<double>(upper.y - p.y) * scale};
  }
};

std::vector<Point> corners(const Lens& lens, const BodyDef& shape, Vec2 position, float angle) {
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  std::vector<Point> list;
  for (const Vec2 k : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}}) {
    const Vec2 r{k.x * shape.half.x, k.y * shape.half.y};
    list.push_back(lens.at(position + Vec2{c * r.x - s * r.y, s * r.x + c * r.y}));
  }
  return list;
}

void draw_shape(Svg& svg, const Lens& lens, const BodyDef& shape, Vec2 position, float angle, const Paint& paint) {
  if (shape.shape == ShapeKind::kCircle) {
    svg.circle(lens.at(position), static_cast<double>(shape.radius) * lens.scale, paint);
  } else {
    svg.polygon(corners(lens, shape, position, angle), paint);
  }
}

void draw_thing(Svg& svg, const Lens& lens, const Thing& t) {
  const Paint paint = paint_of(t.role, t.colour);
  draw_shape(svg, lens, t.shape, t.position, t.angle, paint);
  const Point middle = lens.at(t.position);
  if (!t.label.empty())
    svg.text(middle.x, middle.y + 4, t.label, {.size = 11, .anchor = Anchor::kMiddle, .bold = true});
  const bool rolls = t.label.empty() && (t.role == Role::kBody || t.role == Role::kDisturbed);
  if (t.shape.shape != ShapeKind::kCircle || !rolls) return;
  const Vec2 rim = t.position + Vec2{std::cos(t.angle), std::sin(t.angle)} * t.shape.radius;
  svg.line({middle, lens.at(rim)}, {.stroke = paint.stroke});
}

void draw_frame(Svg& svg, const Lens& lens, const FilmStrip& film, const Frame& frame) {
  const double width = static_cast<double>(film.upper.x - film.lower.x) * lens.scale;
  const double height = static_cast<double>(film.upper.y - film.lower.y) * lens.scale;
  svg.begin_window(lens.x, lens.y, width, height);
  svg.rect(lens.x, lens.y, width, height, {.fill = "#FAFAFA"});
  for (const BodyDef& d : film.scene.statics) draw_shape(svg, lens, d, d.position, d.angle, {.fill = "#DDDDDD"});
  for (const Trail& t : frame.trails) {
    std::vector<Point> points;
    for (const Vec2 p : t.points) points.push_back(lens.at(p));
    svg.line(points, {.stroke = paint_of(t.role, t.colour).fill, .width = 2, .opacity = 0.8});
  }
  for (const Thing& t : frame.things) draw_thing(svg, lens, t);
  if (!frame.note.empty()) {
    const double wide = text_width(frame.note, 13) + 10;
    svg.rect(lens.x + width - wide, lens.y, wide, kLetters + 6, {.fill = "#FAFAFA", .opacity = 0.85});
    svg.text(lens.x + width - 5, lens.y + kLetters, frame.note, {.size = 13, .anchor = Anchor::kEnd});
  }
  svg.end_window();
  svg.rect(lens.x, lens.y, width, height, {.stroke = "#777777"});
}

/// A line with a sign for every role and a bar of known length.
void draw_key(Svg& svg, const FilmStrip& film, double scale, double y) {
  double x = kMargin;
  for (const auto& [role, words, colour] : film.key) {
    svg.circle({x + 7, y - 5}, 7, paint_of(role, colour));
    svg.text(x + 19, y, words, {.size = 14});
    x += 19 + text_width(words, 14) + 20;
  }
  const double bar = static_cast<double>(film.scale_m) * scale;
  const double right = film.width - kMargin;
  svg.line({{right - bar, y - 10}, {right - bar, y - 2}, {right, y - 2}, {right, y - 10}},
           {.stroke = "#000000", .width = 1.5});
  svg.text(right - bar - 6, y, number(static_cast<double>(film.scale_m)) + " m", {.size = 14, .anchor = Anchor::kEnd});
}

}  // namespace

NamedText film_svg(const FilmStrip& film) {
  const auto n = static_cast<double>(film.columns.size());
  const double frame_width = (film.width - 2 * kMargin - (n - 1) * kGap) / n;
  const double scale = frame_width / static_cast<double>(film.upper.x - film.lower.x);
  const double frame_height = static_cast<double>(film.upper.y - film.lower.y) * scale;
  const double head = kMargin + 2 * kLine + 6;
  const double row_height = kLine + frame_height + kGap;
  const double height = head + static_cast<double>(film.rows.size()) * row_height + kLine + kMargin;

  Svg svg(film.width, height);
  svg.text(kMargin, kMargin + kLetters, film.title, {.size = 18, .bold = true});
  const auto left = [&](std::size_t column) { return kMargin + static_cast<double>(column) * (frame_width + kGap); };
  for (std::size_t c = 0; c < film.columns.size(); ++c)
    svg.text(left(c) + frame_width / 2, head - 8, film.columns[c], {.size = kLetters, .anchor = Anchor::kMiddle});
  double y = head;
  for (const FilmRow& row : film.rows) {
    svg.text(kMargin, y + kLetters + 2, row.label, {.size = kLetters, .bold = true});
    svg.text(film.width - kMargin, y + kLetters + 2, row.note,
             {.size = 14, .colour = "#333333", .anchor = Anchor::kEnd});
    for (std::size_t c = 0; c < row.frames.size(); ++c)
      draw_frame(svg, {film.lower, film.upper, left(c), y + kLine, scale}, film, row.frames[c]);
    y += row_height;
  }
  draw_key(svg, film, scale, y + kLine - 4);
  return {film.name + ".svg", svg.text()};
}

}  // namespace padr::plot
