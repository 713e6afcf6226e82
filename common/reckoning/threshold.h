#pragma once

#include "common/reckoning/prediction.h"

namespace padr::sync {

/// The avatar's threshold in force, out of what is predicted: high while nothing is, low while interaction is.
class Threshold {
 public:
  explicit Threshold(const Technique& t) : technique_(t), now_m_(t.threshold_high) {}

  /// From the next adapt on.
  void retune(const Technique& t) { technique_ = t; }

  /// Adapts; `holding`: the avatar touches a body right now, which is interaction whatever is predicted.
  void adapt(const Prediction& p, bool holding, Tick now);
  float metres() const { return now_m_; }

 private:
  // A predicted contact comes and goes with every twitch of the input; the low threshold stays for this long after.
  static constexpr Tick kLinger = 15;  // 250 ms

  Technique technique_;
  float now_m_;
  Tick low_until_ = -1;
  float lingering_level_ = 0;
};

}  // namespace padr::sync
