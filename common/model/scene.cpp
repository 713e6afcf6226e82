#include "common/model/scene.h"

#include "common/model/hash.h"

namespace padr {
namespace {

void add(Hasher& h, Vec2 v) {
  h.add(v.x);
  h.add(v.y);
}

void add(Hasher& h, const BodyDef& b) {
  h.add(static_cast<std::uint64_t>(b.shape));
  h.add(b.radius);
  add(h, b.half);
  add(h, b.position);
  for (const float v : {b.angle, b.mass, b.friction, b.restitution, b.linear_damping, b.angular_damping}) h.add(v);
  add(h, b.velocity);
}

void add(Hasher& h, const AvatarDef& a) {
  for (const float v : {a.radius, a.mass, a.friction, a.restitution, a.stiffness, a.damping, a.max_force, a.max_speed})
    h.add(v);
  h.add(static_cast<std::uint64_t>(a.gravity));
  h.add(static_cast<std::uint64_t>(a.spawns.size()));
  for (const Vec2 s : a.spawns) add(h, s);
}

}  // namespace

std::uint64_t scene_hash(const Scene& scene) {
  Hasher h;
  h.add(scene.name);
  add(h, scene.lower);
  add(h, scene.upper);
  add(h, scene.gravity);
  h.add(static_cast<std::uint64_t>(scene.warm_starting));
  h.add(static_cast<std::uint64_t>(scene.continuous));
  h.add(static_cast<std::uint64_t>(scene.velocity_iterations));
  h.add(static_cast<std::uint64_t>(scene.position_iterations));
  add(h, scene.avatar);
  for (const auto* list : {&scene.bodies, &scene.statics}) {
    h.add(static_cast<std::uint64_t>(list->size()));
    for (const BodyDef& b : *list) add(h, b);
  }
  if (scene.region) {
    h.add(static_cast<std::uint64_t>(scene.region->id));
    for (const std::uint8_t b : scene.region->builds) h.add(static_cast<std::uint64_t>(b));
    for (const char e : scene.region->empty) h.add(static_cast<std::uint64_t>(e));
  }
  // Not of physics; but who believes other things than the rest would drop what they take in.
  if (scene.max_speed != Scene{}.max_speed || scene.max_spin != Scene{}.max_spin) {
    h.add(scene.max_speed);
    h.add(scene.max_spin);
  }
  return h.value();
}

}  // namespace padr
