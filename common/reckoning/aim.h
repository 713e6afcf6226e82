#pragma once

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::sync {

/// Where an avatar's input is heading. People reach: a target that moves goes on moving for a while and slows down, so
/// the best single point to tell others lies ahead of the target that is given now, by its speed times a lead. The lead
/// grows with the time for which others must guess.
class Aim {
 public:
  /// `lead`: seconds, for those whom an update reaches at once; 0 tells the target itself.
  explicit Aim(float lead) : lead_(lead) {}
  /// m; nobody means a point that is further ahead, and others would not believe it.
  static constexpr float kMostLead = 900;
  void retune(float lead) { lead_ = lead; }

  /// The target of this tick, m.
  void follow(Vec2 target) {
    before_ = seen_ ? target_ : target;
    target_ = target;
    seen_ = true;
  }
  /// Where to aim, m. A target that has stopped is told exactly. `way`: ticks that an update takes to its receivers.
  Vec2 ahead(Tick way) const {
    const float lead = lead_ * (1 + static_cast<float>(way) / kDoubled);
    return target_ + clamp_length((target_ - before_) * (lead / kTickSeconds), kMostLead);
  }

 private:
  // The lead is twice as long when an update takes a quarter of a second. Of the recorded hands, the best lead is 0.06
  // s for a guess of 0.15 s, and 0.09 s for one of 0.25 s.
  static constexpr float kDoubled = 15;  // ticks

  float lead_;
  // The last tick's motion: in the mean of more, a hand that turns or brakes is seen too late.
  Vec2 before_;
  Vec2 target_;
  bool seen_ = false;
};

}  // namespace padr::sync
