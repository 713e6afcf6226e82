#include "tools/lab/alternatives/replica.h"

#include "common/world/avatar_control.h"

namespace padr::lab::alternatives {

Replica::Replica(const Scene& scene, const AlternativeConfig& config)
    : world_(scene, config.peers),
      claims_(config.self, static_cast<int>(scene.bodies.size())),
      config_(config),
      mailbox_(config) {
  for (PeerId p = 0; p < config.peers; ++p) {
    world_.set_present(world_.avatar(p), true);
    world_.set_free(p, true);
  }
}

void Replica::receive(std::span<const std::byte> datagram) {
  if (const auto letter = mailbox_.open(datagram)) {
    BitReader r(letter->payload);
    if (take(letter->from, r)) return;
  }
  mailbox_.count_dropped();
}

void Replica::step(Vec2 target) {
  ++now_;
  target_ = target;
  mailbox_.begin_tick();
  before_step();
  world::drive_avatar(world_, config_.self, target);
  world_.step();
  claims_.touch(world_, avatar());
  place_others();
  send();
}

}  // namespace padr::lab::alternatives
