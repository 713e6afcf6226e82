#include <algorithm>

#include "common/scenarios/numbers.h"
#include "common/scenarios/scene_draft.h"
#include "common/scenarios/shapes.h"

namespace padr::scenarios {
namespace {

constexpr float kMinSide = 1;  // m; a smaller play area is a mistake of units

std::string text(Vec2 v) {
  std::string result("(");
  result += rough_text(static_cast<double>(v.x)) + ", " + rough_text(static_cast<double>(v.y)) + ")";
  return result;
}

/// A thing with where it was written, so that bodies, avatars and walls can be compared alike.
struct Placed {
  BodyDef def;
  Origin origin;
};

std::vector<Placed> placed(const std::vector<BodyDef>& defs, const std::vector<Origin>& origins) {
  std::vector<Placed> result;
  for (std::size_t i = 0; i < defs.size(); ++i) result.push_back({defs[i], origins[i]});
  return result;
}

std::vector<Placed> avatars(const SceneDraft& draft, const Document& document) {
  std::vector<Placed> result;
  for (const Vec2 spawn : draft.scene.avatar.spawns) {
    BodyDef avatar;
    avatar.radius = draft.scene.avatar.radius;
    avatar.position = spawn;
    result.push_back({avatar, document.origin("avatar.spawn[" + std::to_string(result.size()) + "]")});
  }
  return result;
}

void check_area(const Scene& scene, const Document& document) {
  const Vec2 size = scene.upper - scene.lower;
  if (size.x >= kMinSide && size.y >= kMinSide) return;
  document.fail(document.origin("upper"), "is " + text(scene.upper) + " m with lower " + text(scene.lower) +
                                              " m, allowed: at least 1 m right of and above lower");
}

void check_inside(const Placed& thing, const Scene& scene, const Document& document) {
  const Vec2 half = extent(thing.def);
  const Vec2 low = thing.def.position - half - scene.lower;
  const Vec2 high = scene.upper - (thing.def.position + half);
  const float room = std::min(std::min(low.x, low.y), std::min(high.x, high.y));
  if (static_cast<double>(room) >= -kTouchTolerance) return;
  document.fail(thing.origin, "at " + text(thing.def.position) + " m is not wholly inside the play area, allowed: " +
                                  text(scene.lower + half) + " .. " + text(scene.upper - half) + " m");
}

void check_apart(const Placed& a, const Placed& b, const Document& document) {
  // Centres far apart need no shapes: most pairs.
  const double far = reach(a.def) + reach(b.def);
  const Vec2 d = a.def.position - b.def.position;
  if (static_cast<double>(dot(d, d)) > far * far) return;
  const double gap = separation(a.def, b.def);
  if (gap >= -kTouchTolerance) return;
  document.fail(a.origin, "at " + text(a.def.position) + " m overlaps " + b.origin.field + " (line " +
                              std::to_string(b.origin.line) + ") at " + text(b.def.position) + " m by " +
                              rough_text(-gap) + " m, allowed: 0 .. " + number_text(kTouchTolerance) + " m");
}

}  // namespace

void check_placement(const SceneDraft& draft, const Document& document) {
  check_area(draft.scene, document);
  const std::vector<Placed> statics = placed(draft.scene.statics, draft.statics);
  std::vector<Placed> moving = placed(draft.scene.bodies, draft.bodies);
  for (Placed& avatar : avatars(draft, document)) moving.push_back(std::move(avatar));
  for (std::size_t i = 0; i < moving.size(); ++i) {
    check_inside(moving[i], draft.scene, document);
    for (const Placed& fixed : statics) check_apart(moving[i], fixed, document);
    for (std::size_t j = 0; j < i; ++j) check_apart(moving[i], moving[j], document);
  }
}

}  // namespace padr::scenarios
