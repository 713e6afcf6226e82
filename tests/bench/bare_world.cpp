#include "tests/bench/bare_world.h"

#include <algorithm>

namespace padr::bench {
BareWorld::BareWorld(const Scene& scene, int avatars, PeerId own)
    : world_({scene.gravity.x, scene.gravity.y}),
      velocity_iterations_(scene.velocity_iterations),
      position_iterations_(scene.position_iterations),
      n_bodies_(scene.bodies.size()),
      own_(own),
      holds_(scene.bodies.size(), 0) {
  world_.SetWarmStarting(scene.warm_starting);
  world_.SetContinuousPhysics(scene.continuous);
  world_.SetContactFilter(this);
  for (const BodyDef& d : scene.bodies) add(d, b2_dynamicBody, false);
  for (int p = 0; p < avatars; ++p) {
    BodyDef d;
    d.radius = scene.avatar.radius;
    d.mass = scene.avatar.mass;
    d.friction = scene.avatar.friction;
    d.restitution = scene.avatar.restitution;
    d.position = scene.avatar.spawns[static_cast<std::size_t>(p)];
    add(d, b2_dynamicBody, true);
  }
  for (const BodyDef& d : scene.statics) add(d, b2_staticBody, false);
}

void BareWorld::add(const BodyDef& d, b2BodyType type, bool avatar) {
  b2BodyDef def;
  def.type = type;
  def.position = {d.position.x, d.position.y};
  def.angle = d.angle;
  def.linearVelocity = {d.velocity.x, d.velocity.y};
  def.linearDamping = d.linear_damping;
  def.angularDamping = d.angular_damping;
  def.fixedRotation = avatar;
  def.userData.pointer = bodies_.size();
  b2Body* body = world_.CreateBody(&def);
  b2CircleShape circle;
  b2PolygonShape box;
  circle.m_radius = d.radius;
  if (d.shape == ShapeKind::kBox) box.SetAsBox(d.half.x, d.half.y);
  b2FixtureDef fixture;
  fixture.shape = d.shape == ShapeKind::kBox ? static_cast<b2Shape*>(&box) : &circle;
  const float area = d.shape == ShapeKind::kBox ? 4 * d.half.x * d.half.y : b2_pi * d.radius * d.radius;
  fixture.density = type == b2_dynamicBody ? d.mass / area : 0;
  fixture.friction = d.friction;
  fixture.restitution = d.restitution;
  body->CreateFixture(&fixture);
  bodies_.push_back(body);
}

bool BareWorld::ShouldCollide(b2Fixture* a, b2Fixture* b) {
  const auto [body, other] = std::minmax(a->GetBody()->GetUserData().pointer, b->GetBody()->GetUserData().pointer);
  const bool with_avatar = body < n_bodies_ && other >= n_bodies_ && bodies_[other]->GetType() == b2_dynamicBody;
  const auto whose = static_cast<PeerId>(other - n_bodies_);
  return !with_avatar || whose == own_ || (holds_[body] & only(whose)) != 0;
}

void BareWorld::put(const std::vector<world::Kinematics>& entities, const std::vector<PeerSet>& holds) {
  for (std::size_t e = 0; e < n_bodies_; ++e) {
    if (holds_[e] == holds[e]) continue;
    holds_[e] = holds[e];
    bodies_[e]->GetFixtureList()->Refilter();
  }
  for (std::size_t e = 0; e < entities.size(); ++e) {
    const world::Kinematics& k = entities[e];
    b2Body& b = *bodies_[e];
    if (b.GetPosition() != b2Vec2(k.position.x, k.position.y) || b.GetAngle() != k.angle)
      b.SetTransform({k.position.x, k.position.y}, k.angle);
    b.SetAwake(k.awake);
    if (!k.awake) continue;
    b.SetLinearVelocity({k.velocity.x, k.velocity.y});
    b.SetAngularVelocity(k.spin);
  }
}

}  // namespace padr::bench
