#include "common/world/box2d_body.h"

#include "common/world/contact_memory.h"

namespace padr::world {
namespace {

float inertia_of(const BodyDef& d) {
  return d.shape == ShapeKind::kCircle ? 0.5F * d.mass * d.radius * d.radius
                                       : d.mass * (d.half.x * d.half.x + d.half.y * d.half.y) / 3.0F;
}

}  // namespace

b2Body* create_body(b2World& world, const BodyDef& d, b2BodyType type, std::size_t slot, bool fixed_rotation) {
  b2BodyDef def;
  def.type = type;
  def.position = to_b2(d.position);
  def.angle = d.angle;
  def.fixedRotation = fixed_rotation;
  def.linearDamping = d.linear_damping;
  def.angularDamping = d.angular_damping;
  def.userData.pointer = slot;
  b2Body* body = world.CreateBody(&def);
  b2CircleShape circle;
  b2PolygonShape box;
  b2FixtureDef fixture;
  if (d.shape == ShapeKind::kCircle) {
    circle.m_radius = d.radius;
    fixture.shape = &circle;
  } else {
    box.SetAsBox(d.half.x, d.half.y);
    fixture.shape = &box;
  }
  fixture.density = 1;
  fixture.friction = d.friction;
  fixture.restitution = d.restitution;
  body->CreateFixture(&fixture);
  if (type == b2_dynamicBody) {
    // The centre of mass exactly at the origin, so that a transform carries it without rounding.
    b2MassData mass;
    mass.mass = d.mass;
    mass.center.SetZero();
    mass.I = inertia_of(d);
    body->SetMassData(&mass);
    body->SetLinearVelocity(to_b2(d.velocity));
  }
  return body;
}

}  // namespace padr::world
