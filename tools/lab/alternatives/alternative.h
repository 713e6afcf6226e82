#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/model/scene.h"
#include "common/replica/replica.h"
#include "tools/lab/alternatives/claims.h"
#include "tools/lab/alternatives/spec.h"

namespace padr::lab::alternatives {

struct AlternativeConfig {
  PeerId self = 0;
  int peers = 1;
  std::uint16_t session = 1;
  Spec spec;
};

/// Counters since the start.
struct AlternativeStats {
  std::uint64_t datagrams_sent = 0;
  std::uint64_t wire_bytes_sent = 0;    ///< IP and UDP headers included
  std::uint64_t states_sent = 0;        ///< of entities, to each receiver
  std::uint64_t largest = 0;            ///< bytes of the largest datagram, IP and UDP not included
  std::uint64_t datagrams_dropped = 0;  ///< that came and were damaged, foreign, or of no use any more
};

/// One peer of a session that is kept together by somebody else's technique; driven as node::Replica is.
class Alternative {
 public:
  virtual ~Alternative() = default;
  /// A datagram has arrived; before the step of the tick in which it has.
  virtual void receive(std::span<const std::byte> datagram) = 0;
  /// Advances to the next tick with the avatar driven towards `target` (m); `outgoing` then holds what to send.
  virtual void step(Vec2 target) = 0;
  virtual const std::vector<node::Outgoing>& outgoing() const = 0;
  /// Where things are in this peer's view.
  virtual const world::World& world() const = 0;
  /// Of an alternative without authority: nobody's.
  virtual const Claim& claim(EntityId body) const = 0;
  /// By how many ticks the view of what `of` owns is meant to lie behind; 0: it is meant to be now.
  virtual Tick delay(PeerId /*of*/) const { return 0; }
  /// By how many ticks the own avatar lags behind its hand: it has followed `target` of so many steps ago.
  virtual Tick hand_delay() const { return 0; }
  /// Whether the view has stood still in the last step, as it had to wait.
  virtual bool frozen() const { return false; }
  /// Of an alternative that simulates from inputs alone: the newest tick of which nothing is guessed any more and that
  /// has been simulated, with its state. Null for all others.
  struct Settled {
    Tick tick = 0;
    const world::Snapshot* state = nullptr;
  };
  virtual Settled settled() const { return {}; }
  virtual const AlternativeStats& stats() const = 0;
};

std::unique_ptr<Alternative> make_alternative(const Scene& scene, const AlternativeConfig& config);

}  // namespace padr::lab::alternatives
