#pragma once

#include "common/model/ids.h"

namespace padr::lab::audit {

// What is allowed beyond what physics gives by itself. Honest members are never seen to need more: tests/lab_audit
// plays them over bad links, and docs/audit.md has what was measured.

// Avatars.
inline constexpr float kSpeedShare = 1.02F;     ///< of a speed
inline constexpr float kSpeedMargin = 0.05F;    ///< m/s
inline constexpr float kTouchingShare = 1.15F;  ///< of a speed after contacts
inline constexpr float kTouchingMargin = 0.5F;  ///< m/s
inline constexpr float kPlaceMargin = 0.03F;    ///< m, of an avatar that touches nothing
inline constexpr float kPushedOut = 1.0F;       ///< m, that an avatar is put aside by what it overlaps
inline constexpr float kVelocityMargin = 0.1F;  ///< m/s, of a change of velocity
inline constexpr float kWayMargin = 2.0F;       ///< m, of the way in kWayTicks
inline constexpr Tick kWayTicks = 2 * kTicksPerSecond;

// Bodies.
inline constexpr float kBodySpeedShare = 1.25F;  ///< of a speed after contacts
inline constexpr float kBodySpeedMargin = 1.5F;  ///< m/s
inline constexpr float kBodyPlaceMargin = 1.0F;  ///< m
inline constexpr float kMostPush = 60.5F;        ///< m/s, of a body that is pushed

inline constexpr float kClaimGaps = 2.0F;  ///< m, that may be missing for a chain of contacts, in all
/// m, from where a body lay untouched to where a member says it is that has begun to touch it. Members whose own trace
/// is not there may play bodies that nobody owns by themselves (`--unowned live`), and have them elsewhere.
inline constexpr float kJump = 2.5F;
inline constexpr float kJumpAlone = 5.0F;
inline constexpr float kAlone = 3.0F;  ///< m, that others must have kept off such a body

// How far another thing may be, in the world of the member that says something, from where it is agreed to be.
inline constexpr float kAvatarUnsure = 2.0F;      ///< m
inline constexpr float kAvatarUnsureTime = 0.7F;  ///< s, times its speed, on top
inline constexpr float kBodyUnsure = 2.5F;        ///< m, of one that has been moved or told of lately
inline constexpr float kBodyUnsureTime = 0.4F;    ///< s, times its speed, on top
inline constexpr float kCalmBodyUnsure = 0.25F;   ///< m, of any other

/// What a member says may rest on what others said, and on contacts, in so many ticks before.
inline constexpr Tick kLately = 2 * kTicksPerSecond;
/// Who was told different things is not judged for so long, ticks.
inline constexpr Tick kMisled = 10 * kTicksPerSecond;

}  // namespace padr::lab::audit
