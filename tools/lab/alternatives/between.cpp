#include "tools/lab/alternatives/between.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace padr::lab::alternatives {
namespace {

constexpr Tick kMostAhead = kTicksPerSecond / 4;

float seconds(Tick ticks) {
  return static_cast<float>(ticks) * kTickSeconds;
}

float turned(float from, float to) {
  return std::remainder(to - from, 2 * std::numbers::pi_v<float>);
}

BodyState beyond(const Quantiser& z, const Around& q, const Playout::Moment& m) {
  BodyState s = z.state(*q.a);
  if (q.before == nullptr || !s.awake) return s;
  const BodyState before = z.state(*q.before);
  const float span = seconds(m.a->tick - m.before->tick);
  const float ahead = seconds(std::min(m.at - m.a->tick, kMostAhead));
  s.velocity = (s.position - before.position) * (1 / span);
  s.spin = turned(before.angle, s.angle) / span;
  s.position = s.position + s.velocity * ahead;
  s.angle += s.spin * ahead;
  return s;
}

}  // namespace

BodyState between(const Quantiser& quantiser, const Around& q, const Playout::Moment& m) {
  if (q.b == nullptr || m.b == m.a) return beyond(quantiser, q, m);
  const BodyState a = quantiser.state(*q.a);
  const BodyState b = quantiser.state(*q.b);
  const float span = seconds(m.b->tick - m.a->tick);
  const Vec2 straight = (b.position - a.position) * (1 / span);
  Vec2 slope_a = straight;
  Vec2 slope_b = straight;
  if (q.before != nullptr)
    slope_a = (b.position - quantiser.state(*q.before).position) * (1 / seconds(m.b->tick - m.before->tick));
  if (q.after != nullptr)
    slope_b = (quantiser.state(*q.after).position - a.position) * (1 / seconds(m.after->tick - m.a->tick));
  const float u = seconds(m.at - m.a->tick) / span;
  const float u2 = u * u;
  const float u3 = u2 * u;
  BodyState s;
  s.position = a.position * (2 * u3 - 3 * u2 + 1) + slope_a * (span * (u3 - 2 * u2 + u)) +
               b.position * (3 * u2 - 2 * u3) + slope_b * (span * (u3 - u2));
  s.velocity = straight;
  s.spin = turned(a.angle, b.angle) / span;
  s.angle = a.angle + turned(a.angle, b.angle) * u;
  s.awake = a.awake || b.awake;
  if (!s.awake) s.velocity = {};
  return s;
}

}  // namespace padr::lab::alternatives
