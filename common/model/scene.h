#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/model/vec.h"

namespace padr {

enum class ShapeKind : std::uint8_t { kCircle, kBox };

/// One thing of a scene: a body that moves, or a fixed obstacle. One shape each, centred on its position.
struct BodyDef {
  ShapeKind shape = ShapeKind::kCircle;
  float radius = 0;  ///< m, circles
  Vec2 half;         ///< m, half width and half height, boxes
  Vec2 position;     ///< m
  float angle = 0;   ///< rad
  float mass = 0;    ///< kg; 0 for fixed obstacles
  float friction = 0.3F;
  float restitution = 0.2F;
  float linear_damping = 0;   ///< 1/s; stands for floor friction in scenes seen from above
  float angular_damping = 0;  ///< 1/s
  Vec2 velocity;              ///< m/s at tick 0
};

/// How an avatar is built and driven: a velocity-limited PD law, force = m * damping * (v_wanted - v), limited to
/// max_force, where v_wanted = (target - position) * stiffness / damping, limited to max_speed.
struct AvatarDef {
  float radius = 0.4F;  ///< m
  float mass = 80;      ///< kg
  float friction = 0.2F;
  float restitution = 0.1F;
  float stiffness = 0;   ///< 1/s^2
  float damping = 0;     ///< 1/s
  float max_force = 0;   ///< N
  float max_speed = 0;   ///< m/s
  bool gravity = false;  ///< whether the scene's gravity acts on avatars
  std::vector<Vec2>
      spawns;  ///< start positions, one per avatar slot; their number is the most peers a session can have
};

/// A scene that is one region of a crowd's plane (docs/crowds.md). Its avatars appear where their owners first say that
/// they are, and its bodies are slots, in which bodies come and go.
struct RegionDef {
  std::uint32_t id = 0;              ///< which region; part of the names of bodies that begin in it
  std::vector<std::uint8_t> builds;  ///< by body: slots of one number hold bodies of one build
  std::vector<char> empty;           ///< by body: 1 if there is nothing in the slot at the beginning
};

/// A scenario with every number filled in: what World is built from. The same scene on every peer, to the bit.
struct Scene {
  std::string name;
  std::string title;           ///< one line for people
  Vec2 lower{0, 0};            ///< m, corner of the play area
  Vec2 upper{20, 15};          ///< m, opposite corner
  Vec2 gravity{0, 0};          ///< m/s^2
  bool warm_starting = false;  ///< Box2D's solver starts from last step's impulses: needed for stacks under gravity
  bool continuous = false;     ///< Box2D's continuous collision against fixed things: for fast small bodies
  int velocity_iterations = 8;
  int position_iterations = 3;
  float max_speed =
      121;              ///< m/s, that is believed: Box2D's own limit is 2 m a step, 120 at 60 Hz, give or take rounding
  float max_spin = 95;  ///< rad/s, likewise: a quarter turn a step, 94.2
  AvatarDef avatar;
  std::vector<BodyDef> bodies;   ///< entity ids 0, 1, ...
  std::vector<BodyDef> statics;  ///< walls, posts, slopes: no entity ids
  std::optional<RegionDef> region;
};

/// A rectangle, m.
struct Area {
  Vec2 lower, upper;
};

/// The play area and `margin` metres around it. What is bound for a region of a crowd may have rolled, or been pushed,
/// to the far side of the region that it comes from before anybody was in both: around a region it is two sides more.
inline Area around(const Scene& scene, float margin) {
  const float out = margin + (scene.region ? 2 * (scene.upper.x - scene.lower.x) : 0);
  return {scene.lower - Vec2{out, out}, scene.upper + Vec2{out, out}};
}

/// Nothing gets further out of the play area than this, m: there World stops it. What others say is believed a little
/// further, as they round it.
inline constexpr float kMostOutside = 19;
/// An angle beyond this, rad, has whole turns taken off.
inline constexpr float kMostAngle = 5.0e4F;

/// Hash over every field that influences physics; peers of a session must agree on it.
std::uint64_t scene_hash(const Scene& scene);

}  // namespace padr
