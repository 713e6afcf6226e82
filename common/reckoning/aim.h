#pragma once

#include <array>

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::sync {

/// Where an avatar's input is heading. People reach: a target that moves goes on moving for a while and slows down, so
/// the best single point to tell others lies ahead of the target that is given now, by its speed times a lead.
class Aim {
 public:
  /// `lead`: seconds; 0 tells the target itself.
  explicit Aim(float lead) : lead_(lead) {}
  /// m; nobody means a point that is further ahead, and others would not believe it.
  static constexpr float kMostLead = 900;
  void retune(float lead) { lead_ = lead; }

  /// The target of this tick, m.
  void follow(Vec2 target) {
    if (seen_ == 0) recent_.fill(target);
    recent_[seen_++ % recent_.size()] = target;
    target_ = target;
  }
  /// Where to aim, m. A target that has stopped is told exactly.
  Vec2 ahead() const {
    constexpr float kSpan = static_cast<float>(kRecent - 1) * kTickSeconds;
    return target_ + clamp_length((target_ - recent_[seen_ % recent_.size()]) * (lead_ / kSpan), kMostLead);
  }

 private:
  // Three ticks: fewer take the grain of a pointing device for motion, more see turns too late.
  static constexpr std::size_t kRecent = 4;

  float lead_;
  Vec2 target_;
  std::array<Vec2, kRecent> recent_{};
  std::size_t seen_ = 0;
};

}  // namespace padr::sync
