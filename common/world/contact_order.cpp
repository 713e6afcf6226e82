#include "common/world/contact_order.h"

#include <algorithm>

#include "common/world/box2d_access.h"

namespace padr::world {
namespace {

bool is_sorted(b2World& world) {
  std::uint32_t last = 0;
  for (b2Contact* c = world.GetContactList(); c != nullptr; c = c->GetNext()) {
    const std::uint32_t key = contact_key(*c);
    if (key < last) return false;
    last = key;
  }
  return true;
}

void clear_edges(b2Body& body) {
  body.*member(access::BodyContacts{}) = nullptr;
}

void push_edge(b2Body& body, b2ContactEdge& edge) {
  b2ContactEdge*& head = body.*member(access::BodyContacts{});
  edge.prev = nullptr;
  edge.next = head;
  if (head != nullptr) head->prev = &edge;
  head = &edge;
}

}  // namespace

std::uint32_t contact_key(const b2Contact& c) {
  const std::uint32_t a = slot_of(*c.GetFixtureA()->GetBody());
  const std::uint32_t b = slot_of(*c.GetFixtureB()->GetBody());
  return (std::min(a, b) << 16U) | std::max(a, b);
}

void find_contacts(b2World& world) {
  const_cast<b2ContactManager&>(world.GetContactManager()).FindNewContacts();
}

void order_contacts(b2World& world, std::vector<b2Contact*>& scratch) {
  auto& manager = const_cast<b2ContactManager&>(world.GetContactManager());
  // Contacts enter all lists at the head and leave them in place, so if the world's list is in order all are.
  if (is_sorted(world)) return;

  scratch.clear();
  for (b2Contact* c = world.GetContactList(); c != nullptr; c = c->GetNext()) scratch.push_back(c);
  std::sort(scratch.begin(), scratch.end(),
            [](const b2Contact* a, const b2Contact* b) { return contact_key(*a) > contact_key(*b); });
  for (b2Contact* c : scratch) {
    clear_edges(*c->GetFixtureA()->GetBody());
    clear_edges(*c->GetFixtureB()->GetBody());
  }
  manager.m_contactList = nullptr;
  for (b2Contact* c : scratch) {  // highest key first, each pushed at the head
    c->*member(access::ContactPrev{}) = nullptr;
    c->*member(access::ContactNext{}) = manager.m_contactList;
    if (manager.m_contactList != nullptr) manager.m_contactList->*member(access::ContactPrev{}) = c;
    manager.m_contactList = c;
    push_edge(*c->GetFixtureA()->GetBody(), c->*member(access::NodeA{}));
    push_edge(*c->GetFixtureB()->GetBody(), c->*member(access::NodeB{}));
  }
}

}  // namespace padr::world
