#pragma once

#include <vector>

#include "tools/lab/audit/finding.h"
#include "tools/lab/audit/limits.h"

namespace padr::lab::audit {

/// What an avatar's owner told of it at one tick.
struct AvatarWord {
  Tick tick = 0;
  Vec2 position;  ///< m
  Vec2 velocity;  ///< m/s
};

/// Two words in succession, and what the avatar may have touched between them.
struct AvatarCase {
  AvatarWord before;
  AvatarWord now;
  bool obstacle = false;  ///< a wall or another obstacle
  bool body = false;
  bool avatar = false;
  float avatars = 0;  ///< m/s, the fastest of others lately
  float bodies = 0;   ///< m/s, likewise
  float seconds() const { return static_cast<float>(now.tick - before.tick) * kTickSeconds; }
  bool touches() const { return obstacle || body || avatar; }
};

/// Fastest that the avatar may have been between the two words, m/s.
float fastest_between(const Limits& limits, const AvatarCase& c);

/// Its speed, its change of velocity, its way.
std::vector<Measure> judge(const Limits& limits, const AvatarCase& c);

/// The same of its whole way over some seconds, with contacts at any time: `way` is the sum of straight lines, m.
Measure judge_way(const Limits& limits, float way, float seconds, float avatars, float bodies);

}  // namespace padr::lab::audit
