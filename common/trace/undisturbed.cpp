#include "common/trace/undisturbed.h"

#include <algorithm>

#include "common/world/avatar_control.h"
#include "common/world/bounding_radius.h"

namespace padr::trace {

Undisturbed::Undisturbed(const Scene& scene, int slots, PeerId self)
    : world_(scene, slots), self_(self), reach_(world::reaches(scene, slots)), none_left_(scene.bodies.size(), 0) {
  world_.set_present(avatar(), true);
  world_.set_free(self, true);
}

void Undisturbed::set_avatar(PeerId p, bool present, bool unseen) {
  if (p == self_) return;
  world_.set_present(world_.avatar(p), present);
  world_.set_free(p, unseen);
  any_unseen_ = any_unseen_ || (present && unseen);
}

// What is as it is seen stays as it is, with the memory of its contacts: a player that nobody disturbs has a copy that
// is its live world.
void Undisturbed::take(std::span<const BodyState> view) {
  for (EntityId e = 0; e < view.size(); ++e)
    if (world_.present(e)) world_.set_state(e, view[e]);
  running_ = true;
  touched_ = false;
  age_ = 0;
}

bool Undisturbed::touches() const {
  const EntityId self = avatar();
  return std::any_of(contacts().begin(), contacts().end(),
                     [&](const Contact& c) { return c.second == self && !world_.is_avatar(c.first); });
}

bool Undisturbed::is_near_any(EntityId e, Vec2 at, const std::vector<char>& left_out) const {
  for (EntityId b = 0; b < left_out.size(); ++b)
    if (b != e && left_out[b] == 0 && world::within_reach(at, reach_[e], world_.position(b), reach_[b])) return true;
  return false;
}

// Most of the time an avatar is on its way, everything of its own sleeps, and there is nothing to step for: it is put
// where it is seen as soon as there is.
bool Undisturbed::may_anything_happen(std::span<const BodyState> before, const std::vector<char>& is_others) const {
  if (touched_ || any_unseen_ || is_near_any(avatar(), before[avatar()].position, none_left_)) return true;
  for (EntityId b = 0; b < is_others.size(); ++b) {
    if (is_others[b] == 0 ? world_.awake(b) : before[b].awake && is_near_any(b, before[b].position, is_others))
      return true;
  }
  return false;
}

void Undisturbed::step(std::span<const BodyState> before, const std::vector<char>& is_others, Vec2 target) {
  ++age_;
  stepped_ = may_anything_happen(before, is_others);
  if (!stepped_) return;
  for (EntityId b = 0; b < is_others.size(); ++b)
    if (is_others[b] != 0) world_.set_state(b, before[b]);
  for (PeerId p = 0; p < world_.slots(); ++p)
    if (const EntityId e = world_.avatar(p); world_.present(e) && (p != self_ || !touched_))
      world_.set_state(e, before[e]);
  world::drive_avatar(world_, self_, target);
  world_.step();
  if (touched_ || !touches()) return;
  touched_ = true;
  age_ = 1;
  ++deeds_;
}

}  // namespace padr::trace
