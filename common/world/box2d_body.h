#pragma once

#include <box2d/box2d.h>

#include <cstddef>

#include "common/model/scene.h"

namespace padr::world {

/// Makes a thing of a scene in a Box2D world, with one fixture, and its slot as user data.
b2Body* create_body(b2World& world, const BodyDef& d, b2BodyType type, std::size_t slot, bool fixed_rotation = false);

}  // namespace padr::world
