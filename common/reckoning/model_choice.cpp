#include "common/reckoning/model_choice.h"

#include "common/world/avatar_control.h"

namespace padr::sync {

Vec2 ModelChoice::by_input(const Moment& m) const {
  Vec2 position = m.position;
  Vec2 velocity = m.velocity;
  for (std::size_t i = 0; i < kHorizon; ++i) {
    velocity = velocity + world::control_force(avatar_, position, velocity, m.aim) * (kTickSeconds / avatar_.mass);
    position = position + velocity * kTickSeconds;
  }
  return position;
}

Vec2 ModelChoice::by_second(const Moment& m) const {
  Vec2 position = m.position;
  Vec2 velocity = m.velocity;
  for (std::size_t i = 0; i < kHorizon; ++i) {
    velocity = clamp_length(velocity + m.acceleration * kTickSeconds, avatar_.max_speed);
    position = position + velocity * kTickSeconds;
  }
  return position;
}

void ModelChoice::follow(const BodyState& truth, Vec2 aim, Vec2 acceleration) {
  Moment& then = past_[seen_ % kHorizon];
  if (seen_ >= kHorizon) {
    input_error_ += (distance(by_input(then), truth.position) - input_error_) / kAveraged;
    second_error_ += (distance(by_second(then), truth.position) - second_error_) / kAveraged;
  }
  then = {truth.position, truth.velocity, aim, acceleration};
  ++seen_;
}

}  // namespace padr::sync
