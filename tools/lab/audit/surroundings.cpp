#include "tools/lab/audit/surroundings.h"

#include <algorithm>

#include "tools/lab/audit/margins.h"

namespace padr::lab::audit {
namespace {

constexpr float kMoves = 0.02F;   // m/s
constexpr float kMoved = 0.001F;  // m
constexpr Tick kNever = -1'000'000;

}  // namespace

Surroundings::Surroundings(const Limits& limits, int bodies, int slots)
    : limits_(limits),
      bodies_(static_cast<std::size_t>(bodies)),
      slots_(static_cast<std::size_t>(slots)),
      stirred_(bodies_, kNever) {}

void Surroundings::note_stirred(const sync::FoldState& at) {
  for (EntityId b = 0; b < bodies_; ++b) {
    const world::Kinematics& k = at.world.entities[b];
    const bool first = frames_.empty();
    const bool moves = k.awake && length(k.velocity) > kMoves;
    const bool moved = !first && distance(k.position, now_.world.entities[b].position) > kMoved;
    if (moves || moved || at.authority[b].holder() != kNoPeer || at.holds[b] != 0) stirred_[b] = at.tick;
  }
}

void Surroundings::hear(const std::vector<sync::Bundle>& said) {
  for (const sync::Bundle& s : said)
    for (const sync::BodyUpdate& u : s.bodies) stirred_[u.body] = now_.tick;
}

void Surroundings::take(const sync::FoldState& at) {
  note_stirred(at);
  now_ = at;
  Frame f;
  for (EntityId b = 0; b < bodies_; ++b)
    f.fastest_body = std::max(f.fastest_body, length(at.world.entities[b].velocity));
  f.avatars.resize(slots_);
  for (std::size_t p = 0; p < slots_; ++p) {
    const world::Kinematics& k = at.world.entities[bodies_ + p];
    f.avatars[p] = {at.avatars[p].present, k.position, length(k.velocity)};
  }
  frames_.push_back(std::move(f));
  if (frames_.size() > static_cast<std::size_t>(kLately)) frames_.pop_front();
}

float Surroundings::fastest_body() const {
  float fastest = 0;
  for (const Frame& f : frames_) fastest = std::max(fastest, f.fastest_body);
  return fastest;
}

float Surroundings::fastest_avatar(PeerId but) const {
  float fastest = 0;
  for (const Frame& f : frames_)
    for (PeerId p = 0; p < slots_; ++p)
      if (p != but && f.avatars[p].present) fastest = std::max(fastest, f.avatars[p].speed);
  return fastest;
}

float Surroundings::unsure(EntityId body) const {
  return is_stirred(body) ? kBodyUnsure + moves_within(body) : kCalmBodyUnsure;
}

float Surroundings::moves_within(EntityId body) const {
  return kCalmBodyUnsure + kBodyUnsureTime * length(now_.world.entities[body].velocity);
}

bool Surroundings::is_alone(EntityId body, PeerId but, float metres) const {
  const Vec2 here = position(body);
  for (EntityId b = 0; b < bodies_; ++b)
    if (b != body && is_stirred(b) && distance(position(b), here) < metres) return false;
  for (const Frame& f : frames_)
    for (PeerId p = 0; p < slots_; ++p)
      if (p != but && f.avatars[p].present && distance(f.avatars[p].position, here) < metres) return false;
  return true;
}

bool Surroundings::may_touch_body(const Way& way) const {
  const float own = limits_.scene().avatar.radius;
  for (EntityId b = 0; b < bodies_; ++b)
    if (way.may_reach(position(b), own + limits_.reach(b) + unsure(b))) return true;
  return false;
}

bool Surroundings::may_touch_avatar(const Way& way, PeerId p) const {
  const float both = 2 * limits_.scene().avatar.radius;
  for (const Frame& f : frames_)
    for (PeerId q = 0; q < slots_; ++q) {
      const Avatar& a = f.avatars[q];
      if (q == p || !a.present) continue;
      if (way.may_reach(a.position, both + kAvatarUnsure + kAvatarUnsureTime * a.speed)) return true;
    }
  return false;
}

// The middle of the way is as far off the straight line as can be.
bool Surroundings::may_touch_obstacle(const Way& way) const {
  const float own = limits_.scene().avatar.radius + kCalmBodyUnsure;
  const Vec2 middle = (way.from + way.to) * 0.5F;
  return limits_.to_obstacle(middle) <= 0.5F * std::max(way.longest, distance(way.from, way.to)) + own;
}

}  // namespace padr::lab::audit
