#include "common/trace/shown_meter.h"

#include <algorithm>
#include <cassert>

#include "common/trace/metrics.h"
#include "common/world/bounding_radius.h"

namespace padr::trace {
namespace {

constexpr float kSame = 0.001F;  // m: no difference
constexpr float kSnap = 0.03F;   // m: the step after a jump is compared with the velocity alone
constexpr auto kSlop = static_cast<float>(kNoiseMetres);

// A freeze: shown to stand while it moves, for a tenth of a second.
constexpr float kMoving = 0.5F;    // m/s
constexpr float kStanding = 0.1F;  // of its stride
constexpr Tick kFreeze = 6;        // ticks
// A stop: from fast to slow within a quarter of a second; looked at until half a second after it was fast.
constexpr float kFast = 1;     // m/s
constexpr float kSlow = 0.1F;  // m/s
constexpr Tick kBraking = 15;  // ticks
constexpr Tick kLook = 30;     // ticks

}  // namespace

void ShownMotion::add(const ShownMotion& o) {
  ticks += o.ticks;
  stride_change_m += o.stride_change_m;
  unexplained_m += o.unexplained_m;
  stops += o.stops;
  overshoot_m += o.overshoot_m;
  overshoot_peak_m = std::max(overshoot_peak_m, o.overshoot_peak_m);
  overlap_m += o.overlap_m;
  overlap_made_m += o.overlap_made_m;
  overlap_peak_m = std::max(overlap_peak_m, o.overlap_peak_m);
  freezes += o.freezes;
  longest_freeze = std::max(longest_freeze, o.longest_freeze);
}

ShownMeter::ShownMeter(const Scene& scene, int slots)
    : outlines_(world::outlines(scene, slots)), reaches_(world::reaches(scene, slots)), seen_(outlines_.size()) {
  for (const BodyDef& d : scene.statics) {
    const world::Pose at{d.position, d.angle};
    fixed_.push_back({world::outline_of(d), at, at, at});
  }
}

void ShownMeter::tick(std::span<const BodyState> live, std::span<const Vec2> shown, const std::vector<bool>& present) {
  assert(live.size() == seen_.size() && shown.size() == seen_.size() && present.size() == seen_.size());
  ++sum_.ticks;
  for (std::size_t e = 0; e < seen_.size(); ++e) {
    if (!present[e])
      seen_[e] = {};
    else if (!seen_[e].rests || shown[e] != seen_[e].shown ||
             live[e].velocity != Vec2{})  // most rest, most of the time
      follow(seen_[e], live[e], shown[e]);
  }
  take_overlaps(live, shown, present);
  for (std::size_t e = 0; e < seen_.size(); ++e) seen_[e].shown = shown[e];
}

void ShownMeter::follow(Seen& seen, const BodyState& live, Vec2 shown) {
  const Vec2 straight = live.velocity * kTickSeconds;
  if (!seen.there) {
    seen = {true, false, shown, straight, straight, 0, {}};
    return;
  }
  const Vec2 stride = shown - seen.shown;
  const float change = distance(stride, seen.stride);
  const float unexplained = change > kSame ? distance_to_segment(stride, seen.expected, straight) : 0;
  sum_.stride_change_m += static_cast<double>(change > kSame ? change : 0);
  sum_.unexplained_m += static_cast<double>(unexplained);
  take_freeze(seen, live, shown, stride);
  take_stop(seen.stop, live, shown);
  seen.stride = stride;
  seen.expected = unexplained > kSnap ? straight : stride;
  seen.rests = stride == Vec2{} && seen.expected == Vec2{} && seen.stop.way == Vec2{} && seen.frozen == 0;
}

void ShownMeter::take_freeze(Seen& seen, const BodyState& live, Vec2 shown, Vec2 stride) {
  const float speed = length(live.velocity);
  const bool stands =
      speed > kMoving && distance(shown, live.position) > kSame && length(stride) < kStanding * speed * kTickSeconds;
  seen.frozen = stands ? seen.frozen + 1 : 0;
  if (seen.frozen == kFreeze) ++sum_.freezes;
  if (seen.frozen >= kFreeze) sum_.longest_freeze = std::max(sum_.longest_freeze, seen.frozen);
}

void ShownMeter::take_stop(Stop& stop, const BodyState& live, Vec2 shown) {
  const float speed = length(live.velocity);
  if (speed > kFast) {
    if (stop.stands) end(stop);
    const Vec2 way = live.velocity * (1 / speed);
    const float at = dot(shown, way);
    stop = {way, std::max(at, dot(live.position, way)), at, 0, false};
    return;
  }
  if (stop.way == Vec2{}) return;
  ++stop.slow;
  stop.reach = std::max(stop.reach, dot(live.position, stop.way));
  stop.farthest = std::max(stop.farthest, dot(shown, stop.way));
  stop.stands = stop.stands || (speed < kSlow && stop.slow <= kBraking);
  if (stop.stands && (stop.slow == kLook || speed > kMoving))
    end(stop);
  else if (!stop.stands && stop.slow > kBraking)
    stop = {};
}

void ShownMeter::end(Stop& stop) {
  const auto over = static_cast<double>(std::max(0.0F, stop.farthest - stop.reach));
  ++sum_.stops;
  sum_.overshoot_m += over;
  sum_.overshoot_peak_m = std::max(sum_.overshoot_peak_m, over);
  stop = {};
}

void ShownMeter::take_overlaps(std::span<const BodyState> live, std::span<const Vec2> shown,
                               const std::vector<bool>& present) {
  const auto is_off = [&](std::size_t e) {
    return shown[e] != live[e].position && present[e] && distance(shown[e], live[e].position) > kSame;
  };
  const auto thing = [&](std::size_t e) {
    const float angle = live[e].angle;
    return Thing{outlines_[e], {live[e].position, angle}, {shown[e], angle}, {seen_[e].shown, angle}};
  };
  had_now_.clear();
  for (std::size_t a = 0; a < seen_.size(); ++a) {
    if (!is_off(a)) continue;
    for (std::size_t b = 0; b < seen_.size(); ++b) {
      if (b == a || !present[b] || !world::within_reach(shown[a], reaches_[a], shown[b], reaches_[b])) continue;
      if (b > a || !is_off(b)) take_overlap({std::min(a, b), std::max(a, b)}, thing(a), thing(b));
    }
    for (std::size_t f = 0; f < fixed_.size(); ++f) take_overlap({a, seen_.size() + f}, thing(a), fixed_[f]);
  }
  had_.swap(had_now_);
}

// A correction may take two things apart that overlapped in the live world until then. What is shown cannot but follow.
void ShownMeter::take_overlap(std::pair<std::size_t, std::size_t> who, const Thing& a, const Thing& b) {
  const float depth = world::overlap(a.shape, a.shown, b.shape, b.shown).depth;
  if (depth <= kSlop) return;
  const float live = world::overlap(a.shape, a.live, b.shape, b.live).depth;
  const auto tracked = had_.find(who);
  const float before =
      tracked != had_.end() ? tracked->second : world::overlap(a.shape, a.before, b.shape, b.before).depth;
  const float had = std::min(depth, std::max(live, before));
  had_now_[who] = had;
  const float beyond = depth - live;
  if (beyond <= kSlop) return;
  sum_.overlap_m += static_cast<double>(beyond);
  sum_.overlap_peak_m = std::max(sum_.overlap_peak_m, static_cast<double>(beyond));
  if (depth - had > kSlop) sum_.overlap_made_m += static_cast<double>(depth - had);
}

}  // namespace padr::trace
