#pragma once

#include "common/model/scene.h"

namespace padr::scenarios {

/// Metres between the surfaces of two things as they stand; when they overlap, minus how far one would have to move to
/// part them.
double separation(const BodyDef& a, const BodyDef& b);

/// Metres from a body's centre to its farthest point.
double reach(const BodyDef& body);

/// Half width and half height of the upright rectangle that just holds the body, m.
Vec2 extent(const BodyDef& body);

/// Square metres.
double area(const BodyDef& body);

}  // namespace padr::scenarios
