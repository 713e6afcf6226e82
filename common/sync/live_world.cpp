#include "common/sync/live_world.h"

#include "common/world/avatar_control.h"

namespace padr::sync {

LiveWorld::LiveWorld(const Scene& scene, const FoldState& start, PeerId self, bool authority)
    : world_(scene, static_cast<int>(start.avatars.size())),
      self_(self),
      avatars_(start.avatars.size()),
      holds_(scene.bodies.size(), 0) {
  for (PeerId p = 0; p < world_.slots(); ++p) world_.set_free(p, p == self || !authority);
  adopt(start, {});
}

void LiveWorld::adopt(const FoldState& predicted, const std::vector<bool>& own) {
  tick_ = predicted.tick;
  avatars_ = predicted.avatars;
  for (PeerId p = 0; p < world_.slots(); ++p) world_.set_present(world_.avatar(p), avatars_[p].present);
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    if (holds_[b] == predicted.holds[b]) continue;
    holds_[b] = predicted.holds[b];
    for (PeerId p = 0; p < world_.slots(); ++p) world_.set_hold(p, b, (holds_[b] & (1U << p)) != 0);
  }
  world_.restore(predicted.world, own);
}

void LiveWorld::push(EntityId b, Vec2 velocity) {
  constexpr float kMost = 60;  // m/s
  world_.set_velocity(b, clamp_length(world_.velocity(b) + velocity, kMost));
}

void LiveWorld::settle(const Bundle& told) {
  if (told.avatar && !told.avatar->awake) world_.set_state(avatar(), {told.avatar->position, 0, {}, 0, false});
  for (const BodyUpdate& u : told.bodies)
    if (u.has_state && !u.state.awake) world_.set_state(u.body, u.state);
}

void LiveWorld::step(Vec2 target) {
  for (PeerId p = 0; p < world_.slots(); ++p) {
    if (p == self_ && avatars_[p].present) {
      world::drive_avatar(world_, p, target);
    } else {
      drive_model(world_, p, avatars_[p], tick_);
    }
  }
  world_.step();
  ++tick_;
}

}  // namespace padr::sync
