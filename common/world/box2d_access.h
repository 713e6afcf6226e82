#pragma once

#include <box2d/box2d.h>

// The things of Box2D 2.4 that a step depends on and that its interface does not reach: a body's sleep timer, its flag
// of being in an island and its list of contacts, a contact's touching flag, and places in lists. Access is by explicit
// template instantiation, where the language ignores access rules (C++20 [temp.spec.general]/6), so Box2D itself stays
// as packaged.
namespace padr::world::access {

template <typename Tag, typename Tag::type Member>
struct Expose {
  friend constexpr typename Tag::type member(Tag) { return Member; }
};

struct SleepTime {
  using type = float b2Body::*;
  friend constexpr type member(SleepTime);
};
template struct Expose<SleepTime, &b2Body::m_sleepTime>;

struct BodyContacts {
  using type = b2ContactEdge* b2Body::*;
  friend constexpr type member(BodyContacts);
};
template struct Expose<BodyContacts, &b2Body::m_contactList>;

struct BodyFlags {
  using type = uint16 b2Body::*;
  friend constexpr type member(BodyFlags);
};
template struct Expose<BodyFlags, &b2Body::m_flags>;

struct BodyPrev {
  using type = b2Body* b2Body::*;
  friend constexpr type member(BodyPrev);
};
template struct Expose<BodyPrev, &b2Body::m_prev>;

struct BodyNext {
  using type = b2Body* b2Body::*;
  friend constexpr type member(BodyNext);
};
template struct Expose<BodyNext, &b2Body::m_next>;

struct WorldBodies {
  using type = b2Body* b2World::*;
  friend constexpr type member(WorldBodies);
};
template struct Expose<WorldBodies, &b2World::m_bodyList>;

struct ContactFlags {
  using type = uint32 b2Contact::*;
  friend constexpr type member(ContactFlags);
};
template struct Expose<ContactFlags, &b2Contact::m_flags>;

struct ContactPrev {
  using type = b2Contact* b2Contact::*;
  friend constexpr type member(ContactPrev);
};
template struct Expose<ContactPrev, &b2Contact::m_prev>;

struct ContactNext {
  using type = b2Contact* b2Contact::*;
  friend constexpr type member(ContactNext);
};
template struct Expose<ContactNext, &b2Contact::m_next>;

struct NodeA {
  using type = b2ContactEdge b2Contact::*;
  friend constexpr type member(NodeA);
};
template struct Expose<NodeA, &b2Contact::m_nodeA>;

struct NodeB {
  using type = b2ContactEdge b2Contact::*;
  friend constexpr type member(NodeB);
};
template struct Expose<NodeB, &b2Contact::m_nodeB>;

inline constexpr uint16 kIslandFlag = 0x0001;    // b2Body::e_islandFlag
inline constexpr uint32 kTouchingFlag = 0x0002;  // b2Contact::e_touchingFlag

inline void set_touching(b2Contact& c, bool touching) {
  uint32& flags = c.*member(ContactFlags{});
  flags = touching ? (flags | kTouchingFlag) : (flags & ~kTouchingFlag);
}

}  // namespace padr::world::access
