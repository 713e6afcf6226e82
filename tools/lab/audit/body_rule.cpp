#include "tools/lab/audit/body_rule.h"

#include <algorithm>
#include <cmath>

#include "tools/lab/audit/margins.h"

namespace padr::lab::audit {

std::vector<Measure> judge(const Limits& limits, const BodyCase& c) {
  std::vector<Measure> all;
  const auto check = [&all](Kind kind, float measured, float allowed) { all.push_back({kind, measured, allowed}); };
  const float fastest = limits.body_speed(c.fastest);
  check(Kind::kBodySpeed, length(c.state.velocity), c.pushed ? std::max(fastest, kMostPush) : fastest);
  check(Kind::kBodySpin, std::abs(c.state.spin) * limits.reach(c.body), 2 * fastest);
  if (c.before)
    check(Kind::kBodyWay, distance(c.state.position, c.before->position),
          fastest * c.before->seconds + kBodyPlaceMargin);
  if (c.lay_at) check(Kind::kBodyJump, distance(c.state.position, *c.lay_at), c.jump);
  return all;
}

}  // namespace padr::lab::audit
