#include "common/reckoning/model_choice.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::sync {

Vec2 ModelChoice::foretold(Model model, AvatarMoment m, Tick ticks) const {
  if (model == Model::kStatic) return m.position;
  for (Tick i = 0; i < ticks; ++i) {
    if (model == Model::kSecond)
      m.velocity = clamp_length(m.velocity + m.acceleration * kTickSeconds, avatar_.max_speed);
    else if (model != Model::kFirst)
      m.velocity =
          m.velocity + world::control_force(avatar_, m.position, m.velocity, m.aim) * (kTickSeconds / avatar_.mass);
    m.position = m.position + m.velocity * kTickSeconds;
  }
  return m.position;
}

void ModelChoice::follow(const BodyState& truth, Vec2 aim, Vec2 acceleration, Tick way) {
  const std::size_t back = std::min(static_cast<std::size_t>(way + kBetween), kLongest);
  if (seen_ >= back) {
    const AvatarMoment& then = past_[(seen_ - back) % kLongest];
    const auto take = [&](Model model, float& error) {
      error += (distance(foretold(model, then, static_cast<Tick>(back)), truth.position) - error) / kAveraged;
    };
    take(Model::kInput, input_error_);
    take(Model::kSecond, second_error_);
  }
  past_[seen_ % kLongest] = {truth.position, truth.velocity, aim, acceleration};
  ++seen_;
}

}  // namespace padr::sync
