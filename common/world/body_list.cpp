#include "common/world/body_list.h"

#include <algorithm>

#include "common/world/box2d_access.h"
#include "common/world/contact_order.h"

namespace padr::world {
void BodyList::begin(b2World& world, const std::vector<b2Body*>& bodies) {
  world_ = &world;
  bodies_ = bodies;
  listed_.clear();
  marked_.assign(bodies.size(), 0);
  is_listed_.assign(bodies.size(), 1);
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot) listed_.push_back(slot);
  last_fixed_ = bodies.empty() ? nullptr : bodies.back()->*member(access::BodyPrev{});
}

void BodyList::end() {
  listed_.clear();
  for (std::uint32_t slot = 0; slot < bodies_.size(); ++slot) listed_.push_back(slot);
  link();
}

void BodyList::woken(std::size_t slot) {
  if (is_listed_[slot] != 0) return;
  is_listed_[slot] = 1;
  woken_.push_back(static_cast<std::uint32_t>(slot));
}

void BodyList::mark(std::uint32_t slot) {
  if (marked_[slot] != 0) return;
  marked_[slot] = 1;
  next_.push_back(slot);
}

// Box2D wakes what begins to touch something awake, and all that touches that.
void BodyList::reach_from(std::uint32_t slot) {
  for (b2ContactEdge* e = bodies_[slot]->GetContactList(); e != nullptr; e = e->next)
    if (e->other->GetType() == b2_dynamicBody && !e->other->IsAwake()) mark(slot_of(*e->other));
}

void BodyList::prepare() {
  next_.clear();
  for (const std::vector<std::uint32_t>* slots : {&listed_, &woken_})
    for (const std::uint32_t slot : *slots)
      if (bodies_[slot]->IsAwake()) mark(slot);
  for (std::size_t i = 0; i < next_.size(); ++i) reach_from(next_[i]);
  for (const std::uint32_t slot : next_) marked_[slot] = 0;
  if (!std::is_sorted(next_.begin(), next_.end())) std::sort(next_.begin(), next_.end());
  if (next_ == listed_) {  // whoever was woken sleeps again
    for (const std::uint32_t slot : woken_) is_listed_[slot] = 0;
    woken_.clear();
    return;
  }
  for (const std::vector<std::uint32_t>* slots : {&listed_, &woken_})
    for (const std::uint32_t slot : *slots) {
      is_listed_[slot] = 0;
      bodies_[slot]->*member(access::BodyFlags{}) &= static_cast<uint16>(~access::kIslandFlag);
    }
  listed_.swap(next_);
  woken_.clear();
  link();
}

// Box2D puts a new body at the head.
void BodyList::link() {
  b2Body* before = last_fixed_;
  const auto append = [&](b2Body* body) {
    if (before == nullptr) {
      world_->*member(access::WorldBodies{}) = body;
    } else {
      before->*member(access::BodyNext{}) = body;
    }
    if (body != nullptr) body->*member(access::BodyPrev{}) = before;
    before = body;
  };
  for (auto slot = listed_.rbegin(); slot != listed_.rend(); ++slot) {
    is_listed_[*slot] = 1;
    append(bodies_[*slot]);
  }
  append(nullptr);
}

}  // namespace padr::world
