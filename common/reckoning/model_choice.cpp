#include "common/reckoning/model_choice.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::sync {

Vec2 ModelChoice::foretold(Model model, const Moment& m, std::size_t ticks) const {
  Vec2 position = m.position;
  Vec2 velocity = m.velocity;
  for (std::size_t i = 0; i < ticks; ++i) {
    velocity = model == Model::kInput
                   ? velocity + world::control_force(avatar_, position, velocity, m.aim) * (kTickSeconds / avatar_.mass)
                   : clamp_length(velocity + m.acceleration * kTickSeconds, avatar_.max_speed);
    position = position + velocity * kTickSeconds;
  }
  return position;
}

void ModelChoice::follow(const BodyState& truth, Vec2 aim, Vec2 acceleration, Tick way) {
  const std::size_t back = std::min(static_cast<std::size_t>(way + kBetween), kLongest);
  if (seen_ >= back) {
    const Moment& then = past_[(seen_ - back) % kLongest];
    const auto take = [&](Model model, float& error) {
      error += (distance(foretold(model, then, back), truth.position) - error) / kAveraged;
    };
    take(Model::kInput, input_error_);
    take(Model::kSecond, second_error_);
  }
  past_[seen_ % kLongest] = {truth.position, truth.velocity, aim, acceleration};
  ++seen_;
}

}  // namespace padr::sync
