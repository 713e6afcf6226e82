#include "common/shown/convergence.h"

#include <algorithm>
#include <cmath>

namespace padr::sync {
namespace {

// Corrections smaller than Box2D's slop are not worth hiding, ones beyond 3 m not worth a glide through everything.
constexpr float kNotice = 0.005F;  // m
constexpr float kGone = 0.0001F;   // m, of a blend: over
constexpr float kTooFar = 3.0F;    // m
// Exponential blend: what is left after one tick. Time constant 100 ms: gone in a quarter of a second.
// Written out, as e^(-1/6) of the C library has another last bit on some processors.
constexpr float kKeep = 0x1.b1660ep-1F;
// Projective velocity blending: a correction that is eased in and out over n ticks changes the shown stride by up to
// 6 / n^2 of the error a tick. Kept below this, which no viewer takes for a jump: half of it takes 1.4 times as
// long and shows a quarter more inconsistency, for nothing that can be seen.
constexpr float kGentle = 0.025F;  // m a tick, a tick
constexpr float kEase = 6;
constexpr float kLeastTicks = 4;  // 67 ms
constexpr float kMostTicks = 40;  // 0.7 s: beyond, what is shown is too long ago
// What counts as a jump: two pixels of a screen 1,280 wide that shows an arena of 20 m.
constexpr float kSnap = 0.03F;  // m

/// `error`: m to be made up for; `turn`: m a tick, by which the stride has to change.
int ticks_for(float error, float turn) {
  const float ticks = std::max(std::sqrt(kEase * error / kGentle), turn / kGentle);
  return static_cast<int>(std::clamp(std::ceil(ticks), kLeastTicks, kMostTicks));
}

/// From 0 to 1, beginning and ending without a jolt.
float ease(float part) {
  return part * part * (3 - 2 * part);
}

}  // namespace

Shown::Shown(Convergence how, std::size_t entities)
    : how_(how),
      shown_(entities),
      stride_(entities),
      jump_(entities),
      offset_(entities),
      blends_(entities),
      busy_(entities, 0) {}

void Shown::begin(const std::vector<world::Kinematics>& live) {
  for (std::size_t e = 0; e < shown_.size(); ++e) shown_[e] = live[e].position;
}

void Shown::retune(Convergence how, const std::vector<world::Kinematics>& live) {
  if (how == how_) return;
  how_ = how;
  for (std::size_t e = 0; e < shown_.size(); ++e) {
    const bool led = !first_ && (offset_[e] != Vec2{} || blends_[e].age >= 0);
    stop(e);
    if (!led) continue;
    busy_[e] = 1;
    const Vec2 offset = shown_[e] - live[e].position;
    if (how == Convergence::kBlend) offset_[e] = offset;
    if (how == Convergence::kPvb)
      blends_[e] = {shown_[e], stride_[e] * static_cast<float>(kTicksPerSecond), 0, ticks_for(length(offset), 0)};
  }
}

Vec2 Shown::lead(std::size_t e, Vec2 live, Vec2 velocity, bool own) {
  const float error = length(jump_[e]);
  if (error >= kTooFar && !own) stop(e);
  const bool corrected = !own && error > kNotice && error < kTooFar;
  switch (how_) {
    case Convergence::kSnap:
      return live;
    case Convergence::kBlend:
      return exponential(e, live, corrected);
    case Convergence::kPvb:
      return projective(e, live, velocity, corrected);
  }
  return live;
}

Vec2 Shown::exponential(std::size_t e, Vec2 live, bool corrected) {
  offset_[e] = length(offset_[e]) < kGone ? Vec2{} : offset_[e] * kKeep;
  if (corrected) offset_[e] = offset_[e] + jump_[e];
  return live + offset_[e];
}

Vec2 Shown::projective(std::size_t e, Vec2 live, Vec2 velocity, bool corrected) {
  Blend& b = blends_[e];
  if (corrected) {
    const float error = distance(live, shown_[e] + stride_[e]);
    const float turn = distance(velocity * kTickSeconds, stride_[e]);
    b = {shown_[e], stride_[e] * static_cast<float>(kTicksPerSecond), 0, ticks_for(error, turn)};
  }
  if (b.age < 0) return live;
  ++b.age;
  const float part = static_cast<float>(b.age) / static_cast<float>(b.ticks);
  b.from = b.from + (b.velocity + (velocity - b.velocity) * part) * kTickSeconds;
  if (b.age >= b.ticks) b.age = -1;
  return b.from + (live - b.from) * ease(part);
}

void Shown::stop(std::size_t e) {
  offset_[e] = {};
  blends_[e].age = -1;
}

void Shown::count_snap(Vec2 stride, Vec2 last_stride, Vec2 straight) {
  const Vec2 off = stride - straight;
  if (dot(off, off) <= kSnap * kSnap) return;  // most strides
  const float beyond = distance_to_segment(stride, last_stride, straight);
  if (beyond <= kSnap) return;
  ++snaps_;
  snap_metres_ += static_cast<double>(beyond);
  largest_snap_ = std::max(largest_snap_, static_cast<double>(beyond));
}

void Shown::advance(const std::vector<world::Kinematics>& live, const std::vector<bool>& own) {
  for (std::size_t e = 0; e < shown_.size(); ++e) {
    Vec2& shown = shown_[e];
    Vec2& stride = stride_[e];
    const Vec2 now = live[e].position;
    const Vec2 straight = live[e].velocity * kTickSeconds;
    const Vec2 before = shown;
    const bool busy = busy_[e] != 0;
    if (before == now && !busy && !first_) {  // most entities, most of the time
      stride = {};
      continue;
    }
    shown = busy && !first_ ? lead(e, now, live[e].velocity, own[e]) : now;
    const Vec2 moved = first_ ? straight : shown - before;
    count_snap(moved, stride, straight);
    // After a jump it goes on as it should, not as it jumped.
    stride = straight;
    if (!busy) continue;
    jump_[e] = {};
    if (blends_[e].age >= 0 || offset_[e] != Vec2{})
      stride = moved;
    else
      busy_[e] = 0;
  }
  first_ = false;
}

}  // namespace padr::sync
