#include "tools/lab/convergence/film.h"

#include <fmt/printf.h>

#include <algorithm>

namespace padr::lab::convergence {
namespace {

using plot::Role;

constexpr Tick kBefore = 15;         // shown of the way before the correction
constexpr Tick kAfter = 30;          // and after it
constexpr Tick kLook = 3;            // after it, the entity itself is drawn
constexpr float kMost = 1.2F;        // m: larger ones do not fit the picture
constexpr float kDot = 0.035F;       // m, radius
constexpr float kHalfWidth = 2.6F;   // m, of a frame
constexpr float kHalfHeight = 1.6F;  // m

BodyDef dot() {
  BodyDef d;
  d.radius = kDot;
  return d;
}

/// What is shown of one correction by one method. Everything is drawn with the middle of the way at (0, 0).
class Shot {
 public:
  Shot(const Footage& f, const Moment& m, std::size_t method) : f_(f), m_(m), method_(method) {
    Vec2 lower = truth(-kBefore);
    Vec2 upper = lower;
    for (Tick t = -kBefore; t < kAfter; ++t)
      for (const Vec2 p : {truth(t), f.shown.front()[index(t)][m.entity]}) {
        lower = {std::min(lower.x, p.x), std::min(lower.y, p.y)};
        upper = {std::max(upper.x, p.x), std::max(upper.y, p.y)};
      }
    middle_ = (lower + upper) * 0.5F;
  }

  plot::Frame frame(const BodyDef& shape) const {
    plot::Frame frame;
    plot::Trail way;
    for (Tick t = -kBefore; t < kAfter; ++t) way.points.push_back(truth(t) - middle_);
    frame.trails.push_back(way);
    const float angle = f_.angles[index(kLook)][m_.entity];
    frame.things.push_back({shape, truth(kLook) - middle_, angle, Role::kOutline, {}});
    frame.things.push_back({shape, shown(kLook) - middle_, angle, Role::kModel, {}});
    float largest = 0;
    for (Tick t = -kBefore; t < kAfter; ++t) {
      frame.things.push_back({dot(), shown(t) - middle_, 0, t == 0 ? Role::kDisturbed : Role::kBody, " "});
      if (t > -kBefore + 1)
        largest = std::max(largest, length(shown(t) - shown(t - 1) - (shown(t - 1) - shown(t - 2))));
    }
    frame.note = fmt::sprintf("stride changes by %.2f m in a tick at most", static_cast<double>(largest));
    return frame;
  }

 private:
  std::size_t index(Tick t) const {
    const Tick at = m_.tick + t;
    return static_cast<std::size_t>(at);
  }
  Vec2 truth(Tick t) const { return f_.truth[index(t)][m_.entity]; }
  Vec2 shown(Tick t) const { return f_.shown[method_][index(t)][m_.entity]; }

  const Footage& f_;
  Moment m_;
  std::size_t method_;
  Vec2 middle_;
};

}  // namespace

plot::FilmStrip film_of(const Footage& footage, const Scene& scene) {
  plot::FilmStrip film;
  film.name = "film-convergence";
  film.title = "Convergence: the same correction as a viewer is shown it, a dot a tick";
  film.lower = {-kHalfWidth, -kHalfHeight};
  film.upper = {kHalfWidth, kHalfHeight};
  for (const std::string_view name : kNames) film.columns.emplace_back(name);
  const auto bodies = static_cast<int>(scene.bodies.size());
  for (const bool of_body : {false, true}) {
    const Moment m = largest_correction(footage, bodies, of_body, kMost, kBefore, kAfter);
    if (m.tick < 0) continue;
    BodyDef shape;
    shape.radius = scene.avatar.radius;
    if (of_body) shape = scene.bodies[m.entity];
    plot::FilmRow row;
    row.label = (of_body ? "A body" : "An avatar") +
                fmt::sprintf(", corrected by %.2f m", static_cast<double>(m.metres)) +
                fmt::sprintf(" at %.2f s", static_cast<double>(m.tick) / kTicksPerSecond);
    row.note = fmt::sprintf("as it stands %.0f ms later", 1000.0 * kLook / kTicksPerSecond);
    for (std::size_t method = 0; method < kMethods.size(); ++method)
      row.frames.push_back(Shot(footage, m, method).frame(shape));
    film.rows.push_back(std::move(row));
  }
  film.key = {{Role::kModel, "as shown"},
              {Role::kOutline, "where its authority has it"},
              {Role::kAvatar, "its true way"},
              {Role::kBody, "shown, a tick each"},
              {Role::kDisturbed, "at the tick of the correction"}};
  film.scale_m = 1;
  return film;
}

}  // namespace padr::lab::convergence
