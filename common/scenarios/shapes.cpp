#include "common/scenarios/shapes.h"

#include <algorithm>
#include <cmath>

#include <limits>
#include <numbers>
#include "common/model/portable_math.h"

namespace padr::scenarios {
namespace {

struct Point {
  double x, y;
};

/// A box in double precision: placements are decided on it once, so rounding must not make gaps of it.
struct Frame {
  explicit Frame(const BodyDef& b)
      : centre{b.position.x, b.position.y},
        c(sin_cos(static_cast<double>(b.angle)).cos),
        s(sin_cos(static_cast<double>(b.angle)).sin),
        half{b.half.x, b.half.y} {}

  Point to_local(Point p) const {
    const double dx = p.x - centre.x;
    const double dy = p.y - centre.y;
    return {c * dx + s * dy, c * dy - s * dx};
  }

  Point centre;
  double c, s;
  Point half;
};

/// Signed distance of a point from a box: minus the depth inside it.
double outside(const Frame& box, Point p) {
  const Point local = box.to_local(p);
  const double dx = std::abs(local.x) - box.half.x;
  const double dy = std::abs(local.y) - box.half.y;
  const double ox = std::max(dx, 0.0);
  const double oy = std::max(dy, 0.0);
  return std::sqrt(ox * ox + oy * oy) + std::min(std::max(dx, dy), 0.0);
}

/// How far `b` stays clear of `a` along a's two axes, the better of them.
double axis_gap(const Frame& a, const Frame& b) {
  const Point d = a.to_local(b.centre);
  const double c = std::abs(a.c * b.c + a.s * b.s);
  const double s = std::abs(a.c * b.s - a.s * b.c);
  const double gap_x = std::abs(d.x) - a.half.x - (b.half.x * c + b.half.y * s);
  const double gap_y = std::abs(d.y) - a.half.y - (b.half.x * s + b.half.y * c);
  return std::max(gap_x, gap_y);
}

/// The least distance of b's corners from `a`.
double corner_gap(const Frame& a, const Frame& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const double x = sx * b.half.x;
      const double y = sy * b.half.y;
      least = std::min(least, outside(a, {b.centre.x + b.c * x - b.s * y, b.centre.y + b.s * x + b.c * y}));
    }
  }
  return least;
}

}  // namespace

double separation(const BodyDef& a, const BodyDef& b) {
  const Point pa{a.position.x, a.position.y};
  const Point pb{b.position.x, b.position.y};
  if (a.shape == ShapeKind::kBox && b.shape == ShapeKind::kBox) {
    const Frame fa(a);
    const Frame fb(b);
    const double gap = std::max(axis_gap(fa, fb), axis_gap(fb, fa));
    // Apart, but perhaps farther than along any axis: then it is from corner to corner.
    return gap <= 0 ? gap : std::min(corner_gap(fa, fb), corner_gap(fb, fa));
  }
  if (a.shape == ShapeKind::kBox) return outside(Frame(a), pb) - b.radius;
  if (b.shape == ShapeKind::kBox) return outside(Frame(b), pa) - a.radius;
  const double dx = pb.x - pa.x;
  const double dy = pb.y - pa.y;
  return std::sqrt(dx * dx + dy * dy) - a.radius - b.radius;
}

double reach(const BodyDef& body) {
  if (body.shape == ShapeKind::kCircle) return body.radius;
  const double x = body.half.x;
  const double y = body.half.y;
  return std::sqrt(x * x + y * y);
}

Vec2 extent(const BodyDef& body) {
  if (body.shape == ShapeKind::kCircle) return {body.radius, body.radius};
  const Frame f(body);
  return {static_cast<float>(std::abs(f.c) * f.half.x + std::abs(f.s) * f.half.y),
          static_cast<float>(std::abs(f.s) * f.half.x + std::abs(f.c) * f.half.y)};
}

double area(const BodyDef& body) {
  if (body.shape == ShapeKind::kCircle) {
    return std::numbers::pi * static_cast<double>(body.radius) * static_cast<double>(body.radius);
  }
  return 4.0 * static_cast<double>(body.half.x) * static_cast<double>(body.half.y);
}

}  // namespace padr::scenarios
