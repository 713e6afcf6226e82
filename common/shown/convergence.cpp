#include "common/shown/convergence.h"

#include <algorithm>
#include <cmath>

#include "common/shown/tracking.h"

namespace padr::sync {
namespace {

// Corrections smaller than Box2D's slop are not worth hiding, ones beyond 3 m not worth a glide through everything.
constexpr float kNotice = 0.005F;  // m
constexpr float kGone = 0.0001F;   // m, of a blend: over
constexpr float kTooFar = 3.0F;    // m
constexpr float kStands = 0.1F;    // m/s: below
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

Shown::Shown(Convergence how, const Scene& scene, int slots)
    : how_(how),
      clearance_(scene, slots),
      shown_(scene.bodies.size() + static_cast<std::size_t>(slots)),
      before_(shown_.size()),
      stride_(shown_.size()),
      jump_(shown_.size()),
      offset_(shown_.size()),
      blends_(shown_.size()),
      busy_(shown_.size(), 0) {}

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
    if (how == Convergence::kBlend || how == Convergence::kTrack) offset_[e] = offset;
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
    case Convergence::kTrack:
      return track(e, live, velocity, corrected);
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

Vec2 Shown::track(std::size_t e, Vec2 live, Vec2 velocity, bool corrected) {
  if (!corrected && offset_[e] == Vec2{}) return live;
  const Vec2 straight = velocity * kTickSeconds;
  const Vec2 want = straight + fastest_glide(shown_[e] + straight - live);
  const Vec2 next = shown_[e] + believable_stride(want, stride_[e], straight);
  offset_[e] = next - live;
  if (length(offset_[e]) >= kGone && !clearance_.is_wall_between(next, live)) return next;
  stop(e);
  return live;
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

// What is led is moved out of other things no faster than its step may change. What stands is not: it would be shown to
// be pushed on after its stop.
void Shown::keep_clear(const world::View& live) {
  led_.clear();
  for (const EntityId e : moving_)
    if (offset_[e] != Vec2{} && length(live.velocity(e)) > kStands) led_.push_back(e);
  for (const EntityId e : clearance_.keep(live, led_, before_, shown_)) {
    const Vec2 straight = live.velocity(e) * kTickSeconds;
    shown_[e] = before_[e] + believable_stride(shown_[e] - before_[e], stride_[e], straight);
    offset_[e] = shown_[e] - live.position(e);
  }
}

void Shown::note(std::size_t e, Vec2 straight) {
  const Vec2 moved = first_ ? straight : shown_[e] - before_[e];
  count_snap(moved, stride_[e], straight);
  // After a jump it goes on as it should, not as it jumped.
  stride_[e] = straight;
  if (busy_[e] == 0) return;
  jump_[e] = {};
  if (blends_[e].age >= 0 || offset_[e] != Vec2{})
    stride_[e] = moved;
  else
    busy_[e] = 0;
}

void Shown::advance(const world::View& view, const std::vector<bool>& own) {
  const std::vector<world::Kinematics>& live = view.kinematics();
  before_ = shown_;
  moving_.clear();
  for (std::size_t e = 0; e < shown_.size(); ++e) {
    const Vec2 now = live[e].position;
    const bool busy = busy_[e] != 0;
    if (shown_[e] == now && !busy && !first_) {  // most entities, most of the time
      stride_[e] = {};
      continue;
    }
    moving_.push_back(static_cast<EntityId>(e));
    shown_[e] = busy && !first_ ? lead(e, now, live[e].velocity, own[e]) : now;
  }
  if (how_ == Convergence::kTrack) keep_clear(view);
  for (const EntityId e : moving_) note(e, live[e].velocity * kTickSeconds);
  first_ = false;
}

}  // namespace padr::sync
