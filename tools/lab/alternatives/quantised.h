#pragma once

#include <cstdint>

#include "common/model/scene.h"
#include "common/model/state.h"
#include "tools/lab/alternatives/bits.h"
#include "tools/lab/alternatives/spec.h"

namespace padr::lab::alternatives {

/// A state in whole numbers, as snapshots and state synchronization send it (Fiedler, "Snapshot Compression"). Finer
/// than in his articles, as here the errors of all entities are summed up: position 1/2048 m or as is asked for, angle
/// 1/4096 turn, velocity 1/128 m/s up to 32 m/s, spin 1/32 rad/s up to 32 rad/s.
struct Quantised {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint32_t angle = 0;
  std::int32_t vx = 0;
  std::int32_t vy = 0;
  std::int32_t spin = 0;
  bool awake = true;
  friend bool operator==(const Quantised&, const Quantised&) = default;
};

/// What of an entity is sent.
struct Fields {
  bool turns = true;  ///< angle and spin; not of avatars
  bool moves = true;  ///< velocities, if awake
};

/// Knows the play area and so how many bits a place takes.
class Quantiser {
 public:
  /// `steps_per_m`: of places, 1 .. 2048.
  explicit Quantiser(const Scene& scene, int steps_per_m = kFinestPlace);

  /// Places far outside of the play area are pulled back to 4 m around it.
  Quantised quantise(const BodyState& s) const;
  /// The same without velocities, as they are in snapshots, so that equal means equal on the wire.
  Quantised place(const BodyState& s) const;
  BodyState state(const Quantised& q) const;
  /// The nearest place that one that was written may be.
  Quantised clamped(Quantised q) const;

  /// `base` is something both ends know: differences to it take fewer bits (Quake 3's delta compression).
  void write(BitWriter& w, const Quantised& q, const Quantised& base, Fields fields) const;
  /// Values that no writer writes are clamped to the nearest that one does.
  Quantised read(BitReader& r, const Quantised& base, Fields fields) const;
  void write_point(BitWriter& w, Vec2 p) const;
  Vec2 read_point(BitReader& r) const;

 private:
  Vec2 origin_;
  float steps_;  ///< of places, per m
  std::int32_t most_x_;
  std::int32_t most_y_;
};

}  // namespace padr::lab::alternatives
