#pragma once

#include <limits>

#include "tools/lab/alternatives/input_track.h"
#include "tools/lab/alternatives/mailbox.h"

namespace padr::lab::alternatives {

/// Inputs alone are sent; every peer simulates everything from them, and all come to the same worlds to the bit. There
/// is no authority. With a prediction of some ticks this is rollback (GGPO), with none it is lockstep.
///
/// An input that is at the hand at tick t drives the step of tick t + input delay, at all peers. A datagram has the
/// inputs of its sender that the receiver is not known to have, at most 64, the oldest first, and acknowledges the
/// receiver's; so a loss costs as long as the next datagram takes. (GGPO disconnects when 64 are not acknowledged.) One
/// goes out at every sending tick: silence cannot be told from loss.
///
/// Rollback: of inputs that have not come the last one before is repeated. When one comes that differs from what was
/// simulated with, the world goes back to the tick before the first such one and is simulated anew up to now.
///
/// The prediction limit: a peer simulates at most so many ticks beyond the newest tick of which it has all inputs
/// (GGPO: 8). When that is reached, its view stands still. In GGPO the local input of that time is refused too, and the
/// session becomes slower. Here clocks agree and ticks have their time: the hand is sampled and told all the same, and
/// as soon as inputs arrive the view catches up at once, so a lasting delay beyond the limit costs lag and not speed.
class InputSync final : public Alternative {
 public:
  InputSync(const Scene& scene, const AlternativeConfig& config);

  void receive(std::span<const std::byte> datagram) override;
  void step(Vec2 target) override;
  const std::vector<node::Outgoing>& outgoing() const override { return mailbox_.outgoing(); }
  const world::World& world() const override { return world_; }
  const Claim& claim(EntityId body) const override;
  Tick hand_delay() const override { return now_ - (tick_ - config_.spec.input_delay); }
  bool frozen() const override { return frozen_; }
  Settled settled() const override;
  const AlternativeStats& stats() const override { return mailbox_.stats(); }

  /// The tick that world() is of.
  Tick tick() const { return tick_; }
  /// Steps that took the place of earlier ones.
  std::uint64_t simulated_again() const { return simulated_again_; }

 private:
  bool take(PeerId from, BitReader& r);
  /// The newest tick of which all inputs are here.
  Tick complete() const;
  void roll_back();
  void advance();
  void forget();
  void send();
  world::Snapshot& saved(Tick tick) { return saved_[static_cast<std::size_t>(tick) % saved_.size()]; }
  const world::Snapshot& saved(Tick tick) const { return saved_[static_cast<std::size_t>(tick) % saved_.size()]; }

  AlternativeConfig config_;
  Quantiser quantiser_;
  world::World world_;
  Mailbox mailbox_;
  Tick now_ = 0;
  Tick tick_ = 0;  ///< of world_
  bool frozen_ = false;
  std::vector<InputTrack> tracks_;                       ///< by peer
  std::vector<Tick> acknowledged_;                       ///< by peer: the newest own input that it is known to have
  Tick first_wrong_ = std::numeric_limits<Tick>::max();  ///< simulated with an input that was another one
  std::vector<world::Snapshot> saved_;                   ///< of the last ticks, by tick modulo size
  std::vector<Quantised> inputs_;                        ///< by peer: memory of a step
  std::uint64_t simulated_again_ = 0;
};

}  // namespace padr::lab::alternatives
