#include "common/world/contact_memory.h"

#include "common/world/box2d_access.h"
#include "common/world/contact_order.h"

namespace padr::world {

void read_contact(b2Contact& c, ContactState& s) {
  const b2Manifold& m = *c.GetManifold();
  s.key = contact_key(c);
  s.local_normal = from_b2(m.localNormal);
  s.local_point = from_b2(m.localPoint);
  s.type = static_cast<std::uint8_t>(m.type);
  s.count = static_cast<std::uint8_t>(m.pointCount);
  s.touching = c.IsTouching();
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const b2ManifoldPoint& p = m.points[i];
    s.points[i] = {};
    if (i < s.count) s.points[i] = {from_b2(p.localPoint), p.normalImpulse, p.tangentImpulse, p.id.key};
  }
}

void write_contact(b2Contact& c, const ContactState& s) {
  b2Manifold& m = *c.GetManifold();
  m.localNormal = to_b2(s.local_normal);
  m.localPoint = to_b2(s.local_point);
  m.type = static_cast<b2Manifold::Type>(s.type);
  m.pointCount = s.count;
  for (std::size_t i = 0; i < s.count; ++i) {
    b2ManifoldPoint& p = m.points[i];
    p.localPoint = to_b2(s.points[i].local);
    p.normalImpulse = s.points[i].normal_impulse;
    p.tangentImpulse = s.points[i].tangent_impulse;
    p.id.key = s.points[i].id;
  }
  access::set_touching(c, s.touching);
}

void forget_contact(b2Contact& c) {
  c.GetManifold()->pointCount = 0;
  access::set_touching(c, false);
}

bool bounds_overlap(const b2Contact& c) {
  const b2Fixture& a = *c.GetFixtureA();
  const b2Fixture& b = *c.GetFixtureB();
  b2AABB box_a;
  b2AABB box_b;
  a.GetShape()->ComputeAABB(&box_a, a.GetBody()->GetTransform(), 0);
  b.GetShape()->ComputeAABB(&box_b, b.GetBody()->GetTransform(), 0);
  return b2TestOverlap(box_a, box_b);
}

bool remembers(b2Contact& c) {
  return c.IsTouching() || c.GetManifold()->pointCount > 0;
}

}  // namespace padr::world
