#include "shell/path_survey.h"

#include <algorithm>
#include <cmath>

#include "common/model/user_error.h"
#include "common/scenarios/numbers.h"

namespace padr::shell {
namespace {

// An avatar that is drawn this much slower than it could go is hardly drawn at all.
constexpr double kIdle = 0.01;
// Who records so many points records them oftener than this, s.
constexpr std::size_t kRecorded = 100;
constexpr double kFarApart = 1;

bool inside(Vec2 p, const Scene& s) {
  return p.x >= s.lower.x && p.x <= s.upper.x && p.y >= s.lower.y && p.y <= s.upper.y;
}

/// To three digits, large numbers in full.
std::string measure(double v) {
  return std::abs(v) >= 100 ? scenarios::number_text(std::round(v)) : scenarios::rough_text(v);
}

std::string range(float low, float high) {
  return measure(static_cast<double>(low)) + " .. " + measure(static_cast<double>(high));
}

std::string box(Vec2 low, Vec2 high) {
  return "x " + range(low.x, high.x) + " m, y " + range(low.y, high.y) + " m";
}

std::string share(std::size_t part, std::size_t whole) {
  return std::to_string(part) + " of its " + std::to_string(whole) + " points";
}

/// The least factor, to a tenth, by which the path's times have to grow for an avatar to keep up. Its speed over a
/// second does not fall in proportion.
double slow_enough(const scenarios::Path& path, const Scene& scene) {
  const auto most = static_cast<double>(scene.avatar.max_speed);
  double factor = 1;
  for (double fastest = survey_path(path, scene).fastest; fastest > most && factor <= kMostStretch;) {
    factor = std::ceil(std::max(factor * fastest / most, factor + 0.05) * 10) / 10;
    std::vector<scenarios::PathPoint> points = path.points();
    for (scenarios::PathPoint& p : points) p.seconds *= factor;
    fastest = survey_path(scenarios::Path(std::move(points)), scene).fastest;
  }
  return factor;
}

std::string remedy(double factor) {
  if (factor > kMostStretch)
    return "not even padr-lab path --stretch " + scenarios::number_text(kMostStretch) +
           " makes it slow enough; are its times milliseconds, or its places pixels?";
  return "padr-lab path --stretch " + scenarios::number_text(factor) + " makes it slow enough";
}

}  // namespace

PathSurvey survey_path(const scenarios::Path& path, const Scene& scene) {
  const std::vector<scenarios::PathPoint>& points = path.points();
  PathSurvey s;
  s.points = points.size();
  s.seconds = path.duration();
  s.lower = s.upper = points.front().position;
  const double span = std::min(1.0, path.duration());
  for (const scenarios::PathPoint& p : points) {
    s.lower = {std::min(s.lower.x, p.position.x), std::min(s.lower.y, p.position.y)};
    s.upper = {std::max(s.upper.x, p.position.x), std::max(s.upper.y, p.position.y)};
    if (!inside(p.position, scene)) ++s.outside;
    const double since = p.seconds - points.front().seconds;
    // The path rests where it ends, so that its last second counts, too.
    const double speed = static_cast<double>(distance(p.position, path.at(since + span, false))) / span;
    s.fastest = std::max(s.fastest, speed);
    if (speed > static_cast<double>(scene.avatar.max_speed)) ++s.too_fast;
  }
  return s;
}

PathNotes notes_on_path(const scenarios::Path& path, std::string_view label, const Scene& scene) {
  const PathSurvey s = survey_path(path, scene);
  const auto most = static_cast<double>(scene.avatar.max_speed);
  const std::string name = "path " + std::string(label);
  const bool endless = scene.region.has_value();  // the plane of a crowd
  PathNotes notes;
  notes.summary = name + ": " + std::to_string(s.points) + " points in " + measure(s.seconds) + " s, " +
                  box(s.lower, s.upper) + ", up to " + measure(s.fastest) + " m/s; " +
                  (endless ? "" : "the world: " + box(scene.lower, scene.upper) + ", ") + "avatars make up to " +
                  measure(most) + " m/s";
  const std::string hint = "; padr-lab path fits paths in pixels and milliseconds to a scenario";
  if (s.outside > 0 && !endless)
    notes.warnings.push_back(name + ": " + share(s.outside, s.points) + " are outside the world (" +
                             box(scene.lower, scene.upper) + ")" + hint);
  if (s.too_fast > 0)
    notes.warnings.push_back(name + ": at " + share(s.too_fast, s.points) +
                             " it asks for more than an avatar can do: up to " + measure(s.fastest) +
                             " m/s, but an avatar reaches only " + measure(most) + " m/s; " +
                             remedy(slow_enough(path, scene)));
  if (s.fastest < kIdle * most)
    notes.warnings.push_back(name + ": it hardly moves, at most " + measure(s.fastest) +
                             " m/s; are its times milliseconds?" + hint);
  else if (const double apart = s.seconds / static_cast<double>(s.points - 1);
           s.points >= kRecorded && apart > kFarApart)
    notes.warnings.push_back(name + ": its points are " + measure(apart) +
                             " s apart on average; are its times milliseconds?" + hint);
  return notes;
}

scenarios::Path fit_path(const scenarios::Path& path, std::string_view label, const Scene& scene, bool turned) {
  std::vector<scenarios::PathPoint> points = path.points();
  if (turned)
    for (scenarios::PathPoint& p : points) p.position.y = -p.position.y;
  const double begin = points.front().seconds;
  const PathSurvey s = survey_path(scenarios::Path(points), scene);
  const auto side = [](float low, float high) { return static_cast<double>(high) - static_cast<double>(low); };
  const double width = side(s.lower.x, s.upper.x);
  const double height = side(s.lower.y, s.upper.y);
  if (width == 0 && height == 0)
    throw UserError(std::string(label) + ": all points are in one place, allowed: a path that moves");
  const double margin = 2 * static_cast<double>(scene.avatar.radius);
  const double room_x = std::max(side(scene.lower.x, scene.upper.x) - margin, 0.0);
  const double room_y = std::max(side(scene.lower.y, scene.upper.y) - margin, 0.0);
  double scale = width > 0 ? room_x / width : room_y / height;
  if (height > 0) scale = std::min(scale, room_y / height);
  const auto fitted = [scale](float v, float low, float high, float world_low, float world_high) {
    const double middle = (static_cast<double>(low) + static_cast<double>(high)) / 2;
    const double world = (static_cast<double>(world_low) + static_cast<double>(world_high)) / 2;
    return static_cast<float>(world + (static_cast<double>(v) - middle) * scale);
  };
  for (scenarios::PathPoint& p : points) {
    p.seconds -= begin;
    p.position = {fitted(p.position.x, s.lower.x, s.upper.x, scene.lower.x, scene.upper.x),
                  fitted(p.position.y, s.lower.y, s.upper.y, scene.lower.y, scene.upper.y)};
  }
  return scenarios::Path(std::move(points));
}

}  // namespace padr::shell
