#pragma once

#include <algorithm>

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::sync {

/// Whether an avatar's model error is worth an update. It is when it exceeds the threshold, or will: an error that
/// began a while ago, because the avatar is driven otherwise than its model, is four times as large after twice the
/// while. By the time-space law (Zhou, Cai, Lee and Turner: Time-space consistency in large-scale distributed virtual
/// environments, 2004) it is worth one, too, when a smaller error has lasted: once its integral over time since it was
/// last put right exceeds threshold times `seconds`. A fast error may then grow to the threshold, a slow one is put
/// right for what it costs all the while.
class ModelError {
 public:
  /// `seconds`: of the time-space law; 0 switches that off.
  explicit ModelError(float seconds) : seconds_(seconds) {}
  void retune(float seconds) { seconds_ = seconds; }

  /// This tick's error, m, and what it will be if nothing is told until then.
  void add(float now, float ahead) {
    worst_ = std::max(now, ahead / kGrown);
    area_ = worst_ < kRight ? 0 : area_ + worst_ * kTickSeconds;
  }
  /// The same of an error that is taken as it is.
  void add(float now) { add(now, now * kGrown); }
  /// Whether it is worth an update, against a threshold (m).
  bool exceeds(float threshold) const { return worst_ > threshold || (seconds_ > 0 && area_ > threshold * seconds_); }
  /// The model has just been put right.
  void corrected() { area_ = 0; }

 private:
  // In twice the time, as it grows with the square of it.
  static constexpr float kGrown = 4;
  // As good as right: Box2D's linear slop.
  static constexpr float kRight = 0.005F;  // m

  float seconds_;
  float worst_ = 0;  ///< m, now or foreseen
  float area_ = 0;   ///< m s
};

}  // namespace padr::sync
