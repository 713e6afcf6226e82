#include "tools/lab/alternatives/dis.h"

#include <algorithm>
#include <cmath>

namespace padr::lab::alternatives {
namespace {

constexpr Tick kHeartbeat = 5 * kTicksPerSecond;
constexpr int kIdBits = 16;
constexpr int kSequenceBits = 16;
constexpr std::size_t kMostEntityBits = kIdBits + kSequenceBits + 8 + 6 * 32;
// Beyond these a value is damaged or a lie; Box2D asserts on what is not finite.
constexpr float kMostPlace = 10000;
constexpr float kMostSpeed = 120;
constexpr float kMostAngle = 100000;

bool sane(const BodyState& s) {
  const bool finite = is_finite(s.position) && is_finite(s.velocity) && std::isfinite(s.angle) && std::isfinite(s.spin);
  return finite && length(s.position) < kMostPlace && length(s.velocity) < kMostSpeed &&
         std::abs(s.angle) < kMostAngle && std::abs(s.spin) < kMostSpeed;
}

}  // namespace

Dis::Dis(const Scene& scene, const AlternativeConfig& config) : Replica(scene, config) {
  for (EntityId e = 0; e < world_.entities(); ++e) believed_.push_back({0, world_.state(e), {}, false});
}

BodyState Dis::at(const Reckoned& r, Tick t) const {
  BodyState s = r.state;
  if (!s.awake) return s;
  const float age = static_cast<float>(t - r.since) * kTickSeconds;
  s.position = s.position + s.velocity * age;
  s.angle += s.spin * age;
  return s;
}

Dis::Reckoned Dis::present(EntityId e) const {
  Reckoned r{now(), world_.state(e), {}, true};
  if (!world_.is_avatar(e)) r.claim = claims_.of(e);
  return r;
}

bool Dis::due(EntityId e) const {
  const Reckoned& b = believed_[e];
  const Reckoned here = present(e);
  const bool other_claim = here.claim.owner != b.claim.owner || here.claim.sequence != b.claim.sequence;
  if (other_claim || here.claim.held != b.claim.held) return true;
  if (b.issued && now() - b.since >= kHeartbeat) return true;
  if (b.state.awake != here.state.awake && !here.state.awake) return true;
  const BodyState reckoned = at(b, now());
  return distance(reckoned.position, here.state.position) > spec().position_threshold ||
         std::abs(reckoned.angle - here.state.angle) > spec().angle_threshold;
}

void Dis::write(BitWriter& w, EntityId e) const {
  const Reckoned& b = believed_[e];
  w.put(e, kIdBits);
  w.flag(b.state.awake);
  w.flag(b.claim.held);
  w.put(0, 6);
  if (!world_.is_avatar(e)) w.put(b.claim.sequence, kSequenceBits);
  w.put_float(b.state.position.x);
  w.put_float(b.state.position.y);
  if (!world_.is_avatar(e)) w.put_float(b.state.angle);
  if (!b.state.awake) return;
  w.put_float(b.state.velocity.x);
  w.put_float(b.state.velocity.y);
  if (!world_.is_avatar(e)) w.put_float(b.state.spin);
}

bool Dis::read(BitReader& r, PeerId from, Tick tick) {
  const auto e = static_cast<EntityId>(r.get(kIdBits));
  if (!r.ok() || e >= world_.entities()) return false;
  const bool body = !world_.is_avatar(e);
  if (!body && e != world_.avatar(from)) return false;
  Reckoned b;
  b.issued = true;
  b.since = tick;
  b.state.awake = r.flag();
  b.claim = {from, 0, r.flag(), b.state.awake};
  r.get(6);
  if (body) b.claim.sequence = static_cast<std::uint16_t>(r.get(kSequenceBits));
  b.state.position.x = r.get_float();
  b.state.position.y = r.get_float();
  if (body) b.state.angle = r.get_float();
  if (b.state.awake) {
    b.state.velocity.x = r.get_float();
    b.state.velocity.y = r.get_float();
    if (body) b.state.spin = r.get_float();
  }
  if (!r.ok() || !sane(b.state)) return false;
  // A late or a second copy of what the same owner has told already.
  const Reckoned& known = believed_[e];
  const bool same = known.issued && known.claim.owner == from && known.claim.sequence == b.claim.sequence;
  if (same && tick <= known.since) return true;
  if (!body || claims_.hear(e, b.claim)) believed_[e] = b;
  return true;
}

bool Dis::take(PeerId from, BitReader& r) {
  const Tick tick = whole_tick(r.get(kTickBits), now());
  const std::uint32_t count = r.get(8);
  for (std::uint32_t i = 0; i < count; ++i)
    if (!read(r, from, tick)) return false;
  return r.ok();
}

void Dis::place_others() {
  for (EntityId e = 0; e < world_.entities(); ++e)
    if (!is_mine(e)) world_.set_state(e, at(believed_[e], now()));
}

void Dis::send() {
  std::vector<EntityId> to_tell;
  for (EntityId e = 0; e < world_.entities(); ++e)
    if (is_mine(e) && due(e)) to_tell.push_back(e);
  constexpr std::size_t kFit = (wire::kMaxPayload * 8 - kTickBits - 8) / kMostEntityBits;
  for (std::size_t first = 0; first < to_tell.size(); first += kFit) {
    const std::size_t count = std::min(kFit, to_tell.size() - first);
    BitWriter w;
    w.put(static_cast<std::uint32_t>(now()) & 0xFFFFU, kTickBits);
    w.put(static_cast<std::uint32_t>(count), 8);
    for (std::size_t i = first; i < first + count; ++i) {
      believed_[to_tell[i]] = present(to_tell[i]);
      write(w, to_tell[i]);
    }
    for (PeerId p = 0; p < peers(); ++p)
      if (p != self()) post(p, w, count);
  }
}

}  // namespace padr::lab::alternatives
