#include "tools/lab/alternatives/replica.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::lab::alternatives {

Replica::Replica(const Scene& scene, const AlternativeConfig& config)
    : world_(scene, config.peers), claims_(config.self, static_cast<int>(scene.bodies.size())), config_(config) {
  for (PeerId p = 0; p < config.peers; ++p) {
    world_.set_present(world_.avatar(p), true);
    world_.set_free(p, true);
  }
}

void Replica::receive(std::span<const std::byte> datagram) {
  wire::SealError error{};
  const auto opened = wire::open(datagram, error);
  const bool ours = opened && opened->header.kind == wire::Kind::kState && opened->header.session == config_.session &&
                    opened->header.sender < config_.peers && opened->header.sender != config_.self;
  if (ours) {
    BitReader r(opened->payload);
    if (take(opened->header.sender, r)) return;
  }
  ++stats_.datagrams_dropped;
}

void Replica::step(Vec2 target) {
  ++now_;
  target_ = target;
  outgoing_.clear();
  before_step();
  world::drive_avatar(world_, config_.self, target);
  world_.step();
  claims_.touch(world_, avatar());
  place_others();
  send();
}

void Replica::post(PeerId to, const BitWriter& payload, std::uint64_t states) {
  node::Outgoing o{to, wire::seal({wire::Kind::kState, config_.self, config_.session}, payload.bytes())};
  ++stats_.datagrams_sent;
  stats_.wire_bytes_sent += o.bytes.size() + node::kIpUdpBytes;
  stats_.states_sent += states;
  stats_.largest = std::max<std::uint64_t>(stats_.largest, o.bytes.size());
  outgoing_.push_back(std::move(o));
}

Tick whole_tick(std::uint32_t bits, Tick now) {
  const auto apart = static_cast<std::int16_t>(static_cast<std::uint16_t>(bits - static_cast<std::uint32_t>(now)));
  return now + apart;
}

}  // namespace padr::lab::alternatives
