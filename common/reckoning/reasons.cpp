#include "common/reckoning/reasons.h"

#include <algorithm>
#include <cmath>

namespace padr::sync {
namespace {

// Box2D's own limits of sleep.
constexpr float kStillSpeed = 0.01F;                       // m/s
constexpr float kStillSpin = 2.0F / 180.0F * 3.14159265F;  // rad/s
// A claim by proxy is made when the predicted world misses a collision or has it clearly differently. Lower, and whole
// piles are claimed for differences that nobody sees; higher, and what the avatar pushes over goes where its model
// would have pushed it, for everybody alike, but not where the player's did (`padr-lab examples`, proxy, "untrue").
constexpr float kProxyShift = 0.01F;  // m, by one step
constexpr float kProxySpeed = 0.3F;   // m/s

// Small errors that would last: the input has stopped changing, or the avatar stands, and the model is still off within
// its threshold, or still drives towards something else. One exact word, of the bodies it owns too, ends that: from
// then on live and predicted are the same and, the input being steady, stay so.
bool is_settled_but_wrong(const OwnAvatar& a) {
  return has_settled(a) && (a.misdriven || a.misplaced || (may_end_exactly(a) && a.any_differs));
}

bool rests(const OwnAvatar& a) {
  return a.since_rest >= kRestAgainTicks && (!a.awake || a.undriven >= kStillTicks);
}

}  // namespace

bool is_still(const BodyState& s) {
  return length(s.velocity) < kStillSpeed && std::abs(s.spin) < kStillSpin;
}

bool is_missed_collision(Vec2 position, Vec2 velocity, const world::Kinematics& believed) {
  return distance(position, believed.position) > kProxyShift || distance(velocity, believed.velocity) > kProxySpeed;
}

bool tells_end_state(const Technique& technique, float ahead_metres) {
  return technique.end_update && (technique.update_every_contact || ahead_metres > kAlongMetres);
}

BodyReason reason_of(const OwnedBody& b, const Technique& technique, float price) {
  const bool always = technique.every_tick && b.awake;
  if (!always && b.rests && b.claim_is_known) {
    const bool state = b.differs && technique.rest_state && (!b.held || b.since_rest_told >= kRestAgainTicks);
    return {state ? std::optional(Cause::kAtRest) : std::nullopt, !b.held};
  }
  const bool off =
      technique.body_threshold > 0 && std::max(b.metres, b.ahead_metres) > technique.body_threshold * price;
  return {always || off ? std::optional(Cause::kBodyThreshold) : std::nullopt, false};
}

bool has_settled(const OwnAvatar& a) {
  return (a.steady >= kSettledTicks || a.stands >= kSettledTicks) && a.since_settled >= kSettledTicks;
}

bool may_end_exactly(const OwnAvatar& a) {
  return a.steady >= kSettledTicks && a.stands >= kSettledTicks && a.since_settled >= kRestAgainTicks;
}

AvatarReason reason_of(const OwnAvatar& a, const Technique& technique) {
  // Nobody sees it before it is told of.
  if (!a.present || a.off || (technique.every_tick && a.awake)) return {Cause::kThreshold, false, false};
  if (tells_input(technique) && is_settled_but_wrong(a))
    return {Cause::kAtRest, may_end_exactly(a) && a.any_differs, false};
  if (rests(a) && (a.awake || a.differs)) return {Cause::kAtRest, false, true};
  return {};
}

}  // namespace padr::sync
