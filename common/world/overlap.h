#pragma once

#include <vector>

#include "common/model/scene.h"

namespace padr::world {

/// A shape without a place.
struct Outline {
  ShapeKind shape = ShapeKind::kCircle;
  float radius = 0;  ///< m, circles
  Vec2 half;         ///< m, half width and half height, boxes
};

/// Where a shape is.
struct Pose {
  Vec2 position;    ///< m
  float angle = 0;  ///< rad
};

/// By entity id: bodies, then avatar slots.
std::vector<Outline> outlines(const Scene& scene, int slots);
Outline outline_of(const BodyDef& d);

/// How far one shape is inside another.
struct Overlap {
  float depth = 0;  ///< m; 0: they are apart or just touch
  Vec2 away;        ///< unit; the first shape, moved by `depth` this way, just touches the second
};

/// By the separating axis theorem; Box2D's skin of a centimetre is not part of a shape here.
Overlap overlap(const Outline& a, Pose at_a, const Outline& b, Pose at_b);

/// Whether the straight way from one point to another, in m, leads through the shape.
bool crosses(Vec2 from, Vec2 to, const Outline& shape, Pose at);

}  // namespace padr::world
