#include "common/sync/validation.h"

#include <algorithm>
#include <cmath>

namespace padr::sync {
namespace {

// m; Aim tells of no point that is more than kMostLead further away, and rounding of none that is beyond max_control.
constexpr float kMostTarget = 9'000;

/// What target points are measured from, m.
Vec2 middle_of_targets(const Scene& scene) {
  return scene.region ? (scene.lower + scene.upper) * 0.5F : Vec2{};
}

struct Checker {
  const Scene& scene;
  int slots;
  const AdmitLimits& limits;

  bool place(Vec2 p) const {
    const auto [lower, upper] = around(scene, limits.margin);
    return is_finite(p) && p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y;
  }
  bool speed(Vec2 v) const { return is_finite(v) && length(v) <= std::min(limits.max_speed, scene.max_speed); }

  bool avatar(const AvatarUpdate& u) const {
    // Targets may lie anywhere a pointer may be; accelerations are bounded by the force over a step, generously.
    const bool control = believable_control(u.model, u.control, scene, limits);
    const bool at_rest_is_still = u.awake || u.velocity == Vec2{};
    return place(u.position) && speed(u.velocity) && control && at_rest_is_still;
  }
  bool body(const BodyState& s) const {
    const bool turn = std::isfinite(s.angle) && std::abs(s.angle) <= limits.max_angle && std::isfinite(s.spin) &&
                      std::abs(s.spin) <= std::min(limits.max_spin, scene.max_spin);
    return place(s.position) && speed(s.velocity) && turn;
  }
};

bool is_admission(const Admission& a, const Checker& check) {
  return a.slot < check.slots && a.incarnation > 0 && a.incarnation < kEndOfNumbers && a.first < kEndOfNumbers &&
         a.at.is_set() && a.have.size() == static_cast<std::size_t>(check.slots) &&
         std::all_of(a.have.begin(), a.have.end(), [](std::uint32_t have) { return have < kEndOfNumbers; });
}

bool is_removal(const Removal& r, const Checker& check) {
  return r.slot < check.slots && r.incarnation < kEndOfNumbers && r.count < kEndOfNumbers;
}

bool is_passage(const Passage& p, const Checker& check) {
  if (!check.scene.region || p.crossings == 0 || p.crossings >= kEndOfNumbers) return false;
  if (p.kind == Passage::Kind::kBound) return p.to != 0 && p.to != check.scene.region->id;
  if (p.kind == Passage::Kind::kOut) return true;
  const std::vector<std::uint8_t>& builds = check.scene.region->builds;
  return check.body(p.state) && std::find(builds.begin(), builds.end(), p.build) != builds.end();
}

DropReason check_bundle(const Bundle& b, const Checker& check) {
  if (b.admission && (!is_admission(*b.admission, check) || b.admission->slot == b.peer)) return DropReason::kValue;
  for (const Removal& r : b.removals)
    if (!is_removal(r, check) || r.slot == b.peer) return DropReason::kValue;
  if (b.going && !check.scene.region) return DropReason::kValue;
  const bool spectator = b.spectates || (b.admission && b.admission->spectator);
  if (spectator && check.scene.region) return DropReason::kValue;
  for (const Passage& p : b.passages)
    if (!is_passage(p, check)) return DropReason::kValue;
  for (const Bundle& p : b.passed_on) {
    if (p.peer >= check.slots || p.peer == b.peer || p.index >= kEndOfNumbers || p.tick < 0 || p.tick > b.tick)
      return DropReason::kValue;
    if (const DropReason why = check_bundle(p, check); why != DropReason::kNone) return why;
  }
  for (const BodyUpdate& u : b.bodies) {
    if (u.body >= check.scene.bodies.size()) return DropReason::kEntity;
    if (!u.has_state) continue;
    // Epochs grow by one a claim: 2^30 of them would take a session of years.
    if (u.epoch == 0 || u.epoch > (1U << 30U) || u.claimed < 0 || u.claimed > b.tick) return DropReason::kValue;
    if (!check.body(u.state)) return DropReason::kValue;
  }
  return b.avatar && !check.avatar(*b.avatar) ? DropReason::kValue : DropReason::kNone;
}

}  // namespace

DropReason admit(const StatePacket& p, const Scene& scene, int slots, Tick now, const AdmitLimits& limits) {
  if (p.mark_tick > now + limits.max_ahead) return DropReason::kTick;
  const Checker check{scene, slots, limits};
  for (std::size_t i = 0; i < p.updates.size(); ++i) {
    const Bundle& b = p.updates[i];
    if (b.index >= p.mark_count || b.tick > p.mark_tick || b.tick < 0) return DropReason::kOrder;
    if (i > 0 && (b.index <= p.updates[i - 1].index || b.tick <= p.updates[i - 1].tick)) return DropReason::kOrder;
    const DropReason why = check_bundle(b, check);
    if (why != DropReason::kNone) return why;
  }
  return DropReason::kNone;
}

DropReason admit(const Bundle& bundle, const Scene& scene, int slots, const AdmitLimits& limits) {
  return check_bundle(bundle, Checker{scene, slots, limits});
}

DropReason admit_claims(const Bundle& b, const FoldState& confirmed) {
  constexpr std::uint32_t kFarAbove = 1U << 20U;
  const bool all = std::all_of(b.bodies.begin(), b.bodies.end(), [&](const BodyUpdate& u) {
    return !u.has_state || u.epoch <= confirmed.authority[u.body].epoch + kFarAbove;
  });
  return all ? DropReason::kNone : DropReason::kValue;
}

bool believable(const BodyState& state, const Scene& scene, const AdmitLimits& limits) {
  return Checker{scene, 0, limits}.body(state);
}

bool believable_control(Model model, Vec2 control, const Scene& scene, const AdmitLimits& limits) {
  const Vec2 from = model == Model::kInput ? middle_of_targets(scene) : Vec2{};
  return is_finite(control) && length(control - from) <= limits.max_control;
}

Vec2 believable_target(Vec2 target, const Scene& scene) {
  constexpr float kSquarable = 1e15F;  // m; beyond it the square of a length is not finite
  const Vec2 from = middle_of_targets(scene);
  Vec2 off = target - from;
  if (length(off) <= kMostTarget) return target;
  off = {std::clamp(off.x, -kSquarable, kSquarable), std::clamp(off.y, -kSquarable, kSquarable)};
  return from + clamp_length(off, kMostTarget);
}

}  // namespace padr::sync
