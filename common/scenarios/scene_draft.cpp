#include "common/scenarios/scene_draft.h"

#include "common/scenarios/numbers.h"
#include "common/scenarios/shapes.h"

namespace padr::scenarios {
namespace {

namespace proto = padr::scenario;

constexpr std::uint64_t kMaxBodies = 5000;
// Speeds told are rounded, and physics rounds, too.
constexpr float kSpeedMargin = 1.01F;

Vec2 vec(const proto::Vec2& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y())};
}

template <typename Message>
void set_shape(BodyDef& body, const Message& from) {
  if (from.has_radius()) {
    body.shape = ShapeKind::kCircle;
    body.radius = static_cast<float>(from.radius());
  } else {
    body.shape = ShapeKind::kBox;
    body.half = vec(from.half());
  }
  body.position = vec(from.position());
  body.angle = static_cast<float>(from.angle());
}

BodyDef body_of(const proto::Body& from, const Origin& origin, const Document& document) {
  BodyDef body;
  set_shape(body, from);
  set_material(body, material_of(document, from.material()));
  set_mass(body, from.has_mass() ? from.mass() : from.density(), from.has_density(), origin, document);
  body.velocity = vec(from.velocity());
  return body;
}

AvatarDef avatar_of(const proto::Avatar& from) {
  AvatarDef avatar;
  avatar.radius = static_cast<float>(from.radius());
  avatar.mass = static_cast<float>(from.mass());
  avatar.friction = static_cast<float>(from.friction());
  avatar.restitution = static_cast<float>(from.restitution());
  avatar.stiffness = static_cast<float>(from.stiffness());
  avatar.damping = static_cast<float>(from.damping());
  avatar.max_force = static_cast<float>(from.max_force());
  avatar.max_speed = static_cast<float>(from.max_speed());
  avatar.gravity = from.gravity();
  for (const proto::Vec2& spawn : from.spawn()) avatar.spawns.push_back(vec(spawn));
  return avatar;
}

/// The horizontal two span the corners, so that nothing can slip through where walls meet.
void add_walls(SceneDraft& draft, const proto::Walls& walls, const Origin& origin) {
  const Vec2 lower = draft.scene.lower;
  const Vec2 upper = draft.scene.upper;
  const Vec2 middle = (lower + upper) * 0.5F;
  const auto half = static_cast<float>(walls.thickness() / 2);
  const auto away = static_cast<float>(walls.distance()) + half;  // play area to centre line
  const Vec2 inner = (upper - lower) * 0.5F + Vec2{away - half, away - half};
  const auto add = [&](Vec2 position, Vec2 extents) {
    BodyDef wall;
    wall.shape = ShapeKind::kBox;
    wall.half = extents;
    wall.position = position;
    wall.friction = static_cast<float>(walls.friction());
    wall.restitution = static_cast<float>(walls.restitution());
    draft.scene.statics.push_back(wall);
    draft.statics.push_back(origin);
  };
  add({middle.x, lower.y - away}, {inner.x + 2 * half, half});
  add({middle.x, upper.y + away}, {inner.x + 2 * half, half});
  add({lower.x - away, middle.y}, {half, inner.y});
  add({upper.x + away, middle.y}, {half, inner.y});
}

void add_statics(SceneDraft& draft, const Document& document) {
  const proto::Scenario& from = document.scenario();
  if (from.has_walls()) add_walls(draft, from.walls(), document.origin("walls"));
  for (int i = 0; i < from.obstacle_size(); ++i) {
    BodyDef fixed;
    set_shape(fixed, from.obstacle(i));
    fixed.friction = static_cast<float>(from.obstacle(i).friction());
    fixed.restitution = static_cast<float>(from.obstacle(i).restitution());
    draft.scene.statics.push_back(fixed);
    draft.statics.push_back(document.origin("obstacle[" + std::to_string(i) + "]"));
  }
}

void add_bodies(SceneDraft& draft, const Document& document) {
  const proto::Scenario& from = document.scenario();
  for (int i = 0; i < from.body_size(); ++i) {
    const Origin origin = document.origin("body[" + std::to_string(i) + "]");
    draft.scene.bodies.push_back(body_of(from.body(i), origin, document));
    draft.bodies.push_back(origin);
  }
  for (int i = 0; i < from.row_size(); ++i) {
    const proto::Row& row = from.row(i);
    const Origin origin = document.origin("row[" + std::to_string(i) + "]");
    BodyDef body = body_of(row.body(), document.origin(origin.field + ".body"), document);
    for (std::uint32_t n = 0; n < row.count(); ++n) {
      body.position = {static_cast<float>(row.body().position().x() + n * row.step().x()),
                       static_cast<float>(row.body().position().y() + n * row.step().y())};
      draft.scene.bodies.push_back(body);
      draft.bodies.push_back(origin);
    }
  }
}

/// Counted before anything is made of the counts.
void check_body_count(const Document& document) {
  std::uint64_t count = static_cast<std::uint64_t>(document.scenario().body_size());
  for (const proto::Row& row : document.scenario().row()) count += row.count();
  for (const proto::Scatter& block : document.scenario().scatter()) count += block.count();
  if (count > kMaxBodies) {
    document.fail({}, "the scenario has " + std::to_string(count) + " bodies in body, row and scatter, allowed: 0 .. " +
                          std::to_string(kMaxBodies));
  }
}

/// What is faster than max_speed is not believed, so nothing may be allowed to be.
void check_speeds(const SceneDraft& draft, const Document& document) {
  const Scene& scene = draft.scene;
  const auto check = [&](float speed, const std::string& field) {
    if (scene.max_speed >= speed * kSpeedMargin) return;
    document.fail(document.origin("max_speed"), "is " + number_text(scene.max_speed) + " m/s with " + field + " " +
                                                    number_text(speed) + " m/s, allowed: at least 1 % more than that");
  };
  check(scene.avatar.max_speed, "avatar.max_speed");
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const std::string& field = draft.bodies[i].field;
    check(length(scene.bodies[i].velocity), field + (field.starts_with("row") ? ".body.velocity" : ".velocity"));
  }
}

}  // namespace

SceneDraft draft_of(const Document& document) {
  const proto::Scenario& from = document.scenario();
  check_body_count(document);
  SceneDraft draft;
  Scene& scene = draft.scene;
  scene.name = from.name();
  scene.title = from.title();
  scene.lower = vec(from.lower());
  scene.upper = vec(from.upper());
  scene.gravity = vec(from.gravity());
  scene.warm_starting = from.warm_starting();
  scene.max_speed = static_cast<float>(from.max_speed());
  scene.max_spin = static_cast<float>(from.max_spin());
  scene.continuous = from.continuous();
  scene.velocity_iterations = static_cast<int>(from.velocity_iterations());
  scene.position_iterations = static_cast<int>(from.position_iterations());
  scene.avatar = avatar_of(from.avatar());
  add_statics(draft, document);
  add_bodies(draft, document);
  check_speeds(draft, document);
  return draft;
}

proto::Material material_of(const Document& document, const proto::Material& own) {
  proto::Material material = document.scenario().material();
  material.MergeFrom(own);
  return material;
}

void set_material(BodyDef& body, const proto::Material& material) {
  body.friction = static_cast<float>(material.friction());
  body.restitution = static_cast<float>(material.restitution());
  body.linear_damping = static_cast<float>(material.linear_damping());
  body.angular_damping = static_cast<float>(material.angular_damping());
}

void set_mass(BodyDef& body, double kg, bool is_density, const Origin& origin, const Document& document) {
  if (is_density) kg *= area(body);
  const auto& rule = proto::Body::descriptor()->FindFieldByName("mass")->options().GetExtension(proto::rule);
  if (kg < rule.min() || kg > rule.max()) {
    document.fail(origin, "weighs " + rough_text(kg) + " kg by its density, allowed: " + number_text(rule.min()) +
                              " .. " + number_text(rule.max()) + " kg");
  }
  body.mass = static_cast<float>(kg);
}

}  // namespace padr::scenarios
