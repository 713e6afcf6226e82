#include "common/reckoning/model_choice.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::sync {

Vec2 ModelChoice::by_input(const Moment& m, std::size_t ticks) const {
  Vec2 position = m.position;
  Vec2 velocity = m.velocity;
  for (std::size_t i = 0; i < ticks; ++i) {
    velocity = velocity + world::control_force(avatar_, position, velocity, m.aim) * (kTickSeconds / avatar_.mass);
    position = position + velocity * kTickSeconds;
  }
  return position;
}

Vec2 ModelChoice::by_second(const Moment& m, std::size_t ticks) const {
  Vec2 position = m.position;
  Vec2 velocity = m.velocity;
  for (std::size_t i = 0; i < ticks; ++i) {
    velocity = clamp_length(velocity + m.acceleration * kTickSeconds, avatar_.max_speed);
    position = position + velocity * kTickSeconds;
  }
  return position;
}

void ModelChoice::follow(const BodyState& truth, Vec2 aim, Vec2 acceleration, Tick way) {
  const std::size_t back = std::min(static_cast<std::size_t>(way + kBetween), kLongest);
  if (seen_ >= back) {
    const Moment& then = past_[(seen_ - back) % kLongest];
    input_error_ += (distance(by_input(then, back), truth.position) - input_error_) / kAveraged;
    second_error_ += (distance(by_second(then, back), truth.position) - second_error_) / kAveraged;
  }
  past_[seen_ % kLongest] = {truth.position, truth.velocity, aim, acceleration};
  ++seen_;
}

}  // namespace padr::sync
