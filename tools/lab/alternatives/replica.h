#pragma once

#include <optional>

#include "common/world/world.h"
#include "tools/lab/alternatives/mailbox.h"

namespace padr::lab::alternatives {

/// What alternatives with authority have in common: a world in which every avatar may push everything, the own avatar
/// driven by input, authority by contact, sealed datagrams. What is sent and what becomes of it is theirs.
class Replica : public Alternative {
 public:
  void receive(std::span<const std::byte> datagram) final;
  void step(Vec2 target) final;
  const std::vector<node::Outgoing>& outgoing() const final { return mailbox_.outgoing(); }
  const world::World& world() const final { return world_; }
  const Claim& claim(EntityId body) const final { return claims_.of(body); }
  const AlternativeStats& stats() const final { return mailbox_.stats(); }

 protected:
  Replica(const Scene& scene, const AlternativeConfig& config);

  /// What a sealed payload says. False: it was of no use, such as damaged or old.
  virtual bool take(PeerId from, BitReader& r) = 0;
  /// Forces and states before the step.
  virtual void before_step() {}
  /// Puts what others own where it belongs in this view; claims have been updated.
  virtual void place_others() = 0;
  virtual void send() = 0;

  void post(PeerId to, const BitWriter& payload, std::uint64_t states) { mailbox_.post(to, payload, states); }
  Tick now() const { return now_; }
  PeerId self() const { return config_.self; }
  int peers() const { return config_.peers; }
  const Spec& spec() const { return config_.spec; }
  EntityId avatar() const { return world_.avatar(config_.self); }
  Vec2 target() const { return target_; }
  bool is_mine(EntityId e) const { return world_.is_avatar(e) ? e == avatar() : claims_.mine(e); }

  world::World world_;
  ClaimTable claims_;

 private:
  AlternativeConfig config_;
  Tick now_ = 0;
  Vec2 target_;
  Mailbox mailbox_;
};

}  // namespace padr::lab::alternatives
