#pragma once

#include <optional>

#include "common/model/ids.h"
#include "common/model/technique.h"
#include "common/sync/updates.h"
#include "common/world/snapshot.h"

namespace padr::sync {

// Why something is told: rules, each about one entity at one tick. They remember nothing. Reporter gathers what they
// ask for and keeps the timers.

/// An update takes along what its avatar or its held bodies are off by more than Box2D's own slop, m.
inline constexpr float kAlongMetres = 0.005F;
/// Box2D's own time until sleep. Sleep cannot be left to Box2D here: what touches a sleeping body of somebody else's is
/// woken by it every tick.
inline constexpr Tick kStillTicks = 30;
/// Time without change after which input or avatar count as steady.
inline constexpr Tick kSettledTicks = 30;
/// Between two words about the same rest. Overwriting a body starts its sleep timer anew, in a pile everybody's: the
/// others' view needs time to fall asleep.
inline constexpr Tick kRestAgainTicks = 4 * kStillTicks;

/// Whether a body moves so little that Box2D would let it fall asleep.
bool is_still(const BodyState& s);

/// Proxy: what a body does in the live world through what this peer's avatar and bodies do to it, and what the others
/// believe of it. Whether they miss a collision, or have it clearly differently.
bool is_missed_collision(Vec2 position, Vec2 velocity, const world::Kinematics& believed);

/// The end of a contact with a body that this peer owns; `ahead_metres`: as in EntityError.
bool tells_end_state(const Technique& technique, float ahead_metres);

/// A body that this peer owns, and that no contact is told of.
struct OwnedBody {
  float metres = 0;        ///< as in EntityError
  float ahead_metres = 0;  ///< as in EntityError
  bool differs = false;    ///< in any bit
  bool awake = true;
  bool rests = false;          ///< asleep, or still for kStillTicks
  bool claim_is_known = true;  ///< all peers have the claim that the ownership rests on
  bool held = false;           ///< the avatar touches it
  Tick since_rest_told = 0;    ///< since it was last told to rest while held
};
struct BodyReason {
  std::optional<Cause> state;  ///< its state is told, for this reason
  bool release = false;        ///< authority over it is given up: it rests
  friend bool operator==(const BodyReason&, const BodyReason&) = default;
};
/// `price`: by what the threshold is multiplied.
BodyReason reason_of(const OwnedBody& body, const Technique& technique, float price = 1);

/// The avatar of this peer. Times are in ticks.
struct OwnAvatar {
  bool present = true;  ///< the others know of it
  bool off = false;     ///< its model is off by more than the threshold in force
  bool awake = true;
  Tick steady = 0;           ///< since the input changed last
  Tick stands = 0;           ///< since the avatar moved last
  Tick undriven = 0;         ///< since anything drove the avatar
  Tick since_settled = 0;    ///< since steady input or a standing avatar was last told exactly
  Tick since_rest = 0;       ///< since it was last told to rest
  bool misdriven = false;    ///< its model drives towards another point than the input
  bool misplaced = false;    ///< it is not where it is believed to be
  bool differs = false;      ///< its position differs in any bit, or it is believed awake
  bool any_differs = false;  ///< it, or a body that this peer owns, differs in any bit; asked for if may_end_exactly
};
struct AvatarReason {
  std::optional<Cause> cause;
  bool exact = false;   ///< everything that differs in any bit is told with it
  bool asleep = false;  ///< it is told to rest
  friend bool operator==(const AvatarReason&, const AvatarReason&) = default;
};
/// Input or avatar have been the same for long enough to be told exactly.
bool has_settled(const OwnAvatar& avatar);
/// The same, and nothing at all is going on.
bool may_end_exactly(const OwnAvatar& avatar);
AvatarReason reason_of(const OwnAvatar& avatar, const Technique& technique);

}  // namespace padr::sync
