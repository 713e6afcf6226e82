#include "tools/lab/audit/avatar_rule.h"

#include <algorithm>

#include "tools/lab/audit/margins.h"

namespace padr::lab::audit {
namespace {

float speed_allowed(const Limits& limits, const AvatarCase& c) {
  return c.body || c.avatar ? limits.avatar_speed_touching(c.avatar ? c.avatars : 0, c.bodies) : limits.avatar_speed();
}

/// Where the avatar was too fast already, it has been braking since.
float still_fast(const Limits& limits, const AvatarCase& c) {
  return length(c.before.velocity) - limits.avatar_acceleration() * c.seconds();
}

}  // namespace

float fastest_between(const Limits& limits, const AvatarCase& c) {
  return std::max(speed_allowed(limits, c), length(c.before.velocity));
}

std::vector<Measure> judge(const Limits& limits, const AvatarCase& c) {
  std::vector<Measure> all;
  const auto check = [&all](Kind kind, float measured, float allowed) { all.push_back({kind, measured, allowed}); };
  const float speed = length(c.now.velocity);
  check(Kind::kAvatarSpeed, speed, std::max(speed_allowed(limits, c), still_fast(limits, c) + kVelocityMargin));
  const float seconds = std::max(c.seconds(), kTickSeconds);
  const float change = distance(c.now.velocity, c.before.velocity);
  if (!c.touches())
    check(Kind::kAvatarAcceleration, change / seconds,
          limits.avatar_acceleration() * kSpeedShare + kVelocityMargin / seconds);
  const float margin = c.touches() ? kPushedOut : kPlaceMargin;
  check(Kind::kAvatarWay, distance(c.now.position, c.before.position),
        fastest_between(limits, c) * c.seconds() + margin);
  return all;
}

Measure judge_way(const Limits& limits, float way, float seconds, float avatars, float bodies) {
  const float fastest = std::max({limits.avatar_speed(), avatars, bodies});
  return {Kind::kAvatarWay, way, fastest * kTouchingShare * seconds + kWayMargin};
}

}  // namespace padr::lab::audit
