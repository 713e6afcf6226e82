#pragma once

#include <algorithm>

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::sync {

/// Whether an avatar's model error is worth an update. It is when it exceeds the threshold now or will within the tick
/// that a word of it takes at least; and, by the time-space law (Zhou, Cai, Lee and Turner: Time-space consistency in
/// large-scale distributed virtual environments, 2004), when a smaller error has lasted: once its integral over time
/// since it was last put right exceeds threshold times `seconds`. A fast error may then grow to the threshold, a slow
/// one is put right for what it costs all the while.
class ModelError {
 public:
  /// `seconds`: of the time-space law; 0 switches that off.
  explicit ModelError(float seconds) : seconds_(seconds) {}
  void retune(float seconds) { seconds_ = seconds; }

  /// This tick's error in position (m) and velocity (m/s).
  void add(Vec2 position, Vec2 velocity) {
    const float now = length(position);
    area_ = now < kRight ? 0 : area_ + now * kTickSeconds;
    soon_ = std::max(now, length(position + velocity * kTickSeconds));
  }
  /// Whether it is worth an update, against a threshold (m).
  bool exceeds(float threshold) const { return soon_ > threshold || (seconds_ > 0 && area_ > threshold * seconds_); }
  /// The model has just been put right.
  void corrected() { area_ = 0; }

 private:
  // As good as right: Box2D's linear slop.
  static constexpr float kRight = 0.005F;  // m

  float seconds_;
  float soon_ = 0;  ///< m, now or a tick on
  float area_ = 0;  ///< m s
};

}  // namespace padr::sync
