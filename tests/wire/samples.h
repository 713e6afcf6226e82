#pragma once

#include <memory>
#include <vector>

#include "common/model/rng.h"
#include "common/sync/agreed_world.h"
#include "common/wire/codec.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::test {

// Valid messages of every kind, drawn at random: what codecs must carry to the bit, and where fuzzing begins.

/// Of one sort each: entities, a goodbye, an admission, a removal, or an update passed on, up to `depth` deep.
sync::Bundle any_bundle(Rng& rng, PeerId peer, std::uint32_t index, Tick tick, int depth = sync::kMaxPassing);
sync::StatePacket any_packet(Rng& rng, PeerId sender);
/// Of a region of a crowd: passages of bodies, or going.
sync::Bundle any_crossing(Rng& rng, PeerId peer, std::uint32_t index, Tick tick);
/// An Ask or a Tell.
wire::SessionMessage any_finding(Rng& rng);
/// Of each alternative of the variant in turn.
wire::MembershipMessage any_membership(Rng& rng, std::size_t kind);
inline constexpr std::size_t kMembershipKinds = std::variant_size_v<wire::MembershipMessage>;

/// The largest update there may be, every number as long as it gets within a session of 51 days, in `passings` others,
/// all signed or none.
sync::Bundle largest_bundle(int passings, bool is_signed = false);

/// A session in which somebody comes in and somebody is lost, as one agreed world heard of it.
class Played {
 public:
  static constexpr int kSlots = 4;
  static constexpr Tick kComesIn = 60;
  static constexpr Tick kIsOut = 120;

  explicit Played(std::uint64_t seed, Tick ticks = 200);

  const Scene& scene() const { return scene_; }
  const sync::AgreedWorld& world() const { return world_; }
  sync::Transfer transfer() const;
  /// Plays `world`, which is at or behind the same tick, on to `tick` with the same updates.
  void play(sync::AgreedWorld& world, Tick tick) const;
  /// Plays on.
  void play(Tick tick) { play(world_, tick); }

 private:
  void feed(sync::AgreedWorld& world, Tick t) const;
  void write_log(std::uint64_t seed);

  Scene scene_;
  std::vector<sync::Bundle> log_;  ///< by tick and peer
  sync::AgreedWorld world_;
};

}  // namespace padr::test
