#include "tools/lab/alternatives/quantised.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace padr::lab::alternatives {
namespace {

constexpr float kMargin = 4;  // m around the play area
constexpr int kAngleBits = 12;
constexpr float kTurn = 2 * std::numbers::pi_v<float>;
constexpr float kSpeed = 128;       // steps per m/s
constexpr int kSpeedBits = 13;      // -32 .. 32 m/s
constexpr float kSpin = 32;         // steps per rad/s
constexpr int kSpinBits = 11;       // -32 .. 32 rad/s
constexpr int kSmallRateBits = 6;   // of a difference of velocities or spins
constexpr int kSmallAngleBits = 7;  // of a difference

// Widths of a difference along one axis, chosen by two bits; the last choice is the place itself.
constexpr std::array<int, 3> kSteps{6, 9, 12};

std::int32_t rounded(float v, int bits) {
  const auto most = static_cast<float>((1 << (bits - 1)) - 1);
  return static_cast<std::int32_t>(std::lround(std::clamp(v, -most, most)));
}

bool fits(std::int32_t v, int bits) {
  return v >= -(1 << (bits - 1)) && v < (1 << (bits - 1));
}

void write_axis(BitWriter& w, std::int32_t v, std::int32_t base, std::int32_t most) {
  for (std::size_t i = 0; i < kSteps.size(); ++i) {
    if (!fits(v - base, kSteps[i])) continue;
    w.put(static_cast<std::uint32_t>(i), 2);
    w.put_signed(v - base, kSteps[i]);
    return;
  }
  w.put(static_cast<std::uint32_t>(kSteps.size()), 2);
  w.put(static_cast<std::uint32_t>(v), width_of(static_cast<std::uint32_t>(most)));
}

std::int32_t read_axis(BitReader& r, std::int32_t base, std::int32_t most) {
  const std::uint32_t choice = r.get(2);
  const std::int32_t v = choice < kSteps.size()
                             ? base + r.get_signed(kSteps[choice])
                             : static_cast<std::int32_t>(r.get(width_of(static_cast<std::uint32_t>(most))));
  return std::clamp(v, 0, most);
}

void write_angle(BitWriter& w, std::uint32_t angle, std::uint32_t base) {
  constexpr std::uint32_t kTurnMask = (1U << static_cast<unsigned>(kAngleBits)) - 1;
  w.flag(angle != base);
  if (angle == base) return;
  constexpr std::uint32_t kHalf = 1U << static_cast<unsigned>(kSmallAngleBits - 1);
  const std::uint32_t shifted = (angle - base + kHalf) & kTurnMask;
  const bool small = shifted < 2 * kHalf;
  w.flag(small);
  w.put(small ? shifted : angle, small ? kSmallAngleBits : kAngleBits);
}

std::uint32_t read_angle(BitReader& r, std::uint32_t base) {
  constexpr std::uint32_t kTurnMask = (1U << static_cast<unsigned>(kAngleBits)) - 1;
  constexpr std::uint32_t kHalf = 1U << static_cast<unsigned>(kSmallAngleBits - 1);
  if (!r.flag()) return base;
  if (!r.flag()) return r.get(kAngleBits);
  return (base + r.get(kSmallAngleBits) - kHalf) & kTurnMask;
}

void write_rate(BitWriter& w, std::int32_t v, std::int32_t base, int bits) {
  const bool near = fits(v - base, kSmallRateBits);
  w.flag(near);
  w.put_signed(near ? v - base : v, near ? kSmallRateBits : bits);
}

std::int32_t read_rate(BitReader& r, std::int32_t base, int bits) {
  const std::int32_t most = (1 << (bits - 1)) - 1;
  const std::int32_t v = r.flag() ? base + r.get_signed(kSmallRateBits) : r.get_signed(bits);
  return std::clamp(v, -most, most);
}

}  // namespace

Quantiser::Quantiser(const Scene& scene, int steps_per_m)
    : origin_{scene.lower.x - kMargin, scene.lower.y - kMargin},
      steps_(static_cast<float>(steps_per_m)),
      most_x_(static_cast<std::int32_t>((scene.upper.x - scene.lower.x + 2 * kMargin) * steps_)),
      most_y_(static_cast<std::int32_t>((scene.upper.y - scene.lower.y + 2 * kMargin) * steps_)) {}

Quantised Quantiser::place(const BodyState& s) const {
  Quantised q;
  const auto axis = [this](float v, std::int32_t most) {
    return static_cast<std::int32_t>(std::lround(std::clamp(v * steps_, 0.0F, static_cast<float>(most))));
  };
  q.x = axis(s.position.x - origin_.x, most_x_);
  q.y = axis(s.position.y - origin_.y, most_y_);
  const float turns = s.angle / kTurn;
  constexpr auto kAngles = static_cast<float>(1 << kAngleBits);
  q.angle = static_cast<std::uint32_t>(std::lround((turns - std::floor(turns)) * kAngles)) % (1U << kAngleBits);
  q.awake = s.awake;
  return q;
}

Quantised Quantiser::clamped(Quantised q) const {
  q.x = std::clamp(q.x, 0, most_x_);
  q.y = std::clamp(q.y, 0, most_y_);
  return q;
}

Quantised Quantiser::quantise(const BodyState& s) const {
  Quantised q = place(s);
  if (!s.awake) return q;
  q.vx = rounded(s.velocity.x * kSpeed, kSpeedBits);
  q.vy = rounded(s.velocity.y * kSpeed, kSpeedBits);
  q.spin = rounded(s.spin * kSpin, kSpinBits);
  return q;
}

BodyState Quantiser::state(const Quantised& q) const {
  BodyState s;
  s.position = {origin_.x + static_cast<float>(q.x) / steps_, origin_.y + static_cast<float>(q.y) / steps_};
  s.angle = static_cast<float>(q.angle) / static_cast<float>(1 << kAngleBits) * kTurn;
  s.velocity = {static_cast<float>(q.vx) / kSpeed, static_cast<float>(q.vy) / kSpeed};
  s.spin = static_cast<float>(q.spin) / kSpin;
  s.awake = q.awake;
  return s;
}

void Quantiser::write(BitWriter& w, const Quantised& q, const Quantised& base, Fields fields) const {
  w.flag(q.awake);
  const bool moved = q.x != base.x || q.y != base.y;
  w.flag(moved);
  if (moved) {
    write_axis(w, q.x, base.x, most_x_);
    write_axis(w, q.y, base.y, most_y_);
  }
  if (fields.turns) write_angle(w, q.angle, base.angle);
  if (!fields.moves || !q.awake) return;
  write_rate(w, q.vx, base.vx, kSpeedBits);
  write_rate(w, q.vy, base.vy, kSpeedBits);
  if (fields.turns) write_rate(w, q.spin, base.spin, kSpinBits);
}

Quantised Quantiser::read(BitReader& r, const Quantised& base, Fields fields) const {
  Quantised q;
  q.x = base.x;
  q.y = base.y;
  q.awake = r.flag();
  if (r.flag()) {
    q.x = read_axis(r, base.x, most_x_);
    q.y = read_axis(r, base.y, most_y_);
  }
  if (fields.turns) q.angle = read_angle(r, base.angle);
  if (!fields.moves || !q.awake) return q;
  q.vx = read_rate(r, base.vx, kSpeedBits);
  q.vy = read_rate(r, base.vy, kSpeedBits);
  if (fields.turns) q.spin = read_rate(r, base.spin, kSpinBits);
  return q;
}

void Quantiser::write_point(BitWriter& w, Vec2 p) const {
  BodyState s;
  s.position = p;
  const Quantised q = place(s);
  w.put(static_cast<std::uint32_t>(q.x), width_of(static_cast<std::uint32_t>(most_x_)));
  w.put(static_cast<std::uint32_t>(q.y), width_of(static_cast<std::uint32_t>(most_y_)));
}

Vec2 Quantiser::read_point(BitReader& r) const {
  Quantised q;
  q.x = std::min(static_cast<std::int32_t>(r.get(width_of(static_cast<std::uint32_t>(most_x_)))), most_x_);
  q.y = std::min(static_cast<std::int32_t>(r.get(width_of(static_cast<std::uint32_t>(most_y_)))), most_y_);
  return state(q).position;
}

}  // namespace padr::lab::alternatives
