#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lab/audit/members.h"

namespace padr::lab::audit {

/// What a member did, the most serious first.
enum class Kind : std::uint8_t {
  kTwoUpdates,          ///< two different updates with one number
  kAvatarSpeed,         ///< m/s
  kAvatarAcceleration,  ///< m/s^2, with nothing near
  kAvatarWay,           ///< m, from the last place told, or in kWayTicks
  kClaim,               ///< m, that the body was away from anything of the member's
  kBodySpeed,           ///< m/s, that contacts cannot give
  kBodySpin,            ///< m/s, of the rim
  kBodyWay,             ///< m, between two states of one authority
  kBodyJump,            ///< m, from where the body was agreed to lie
};
inline constexpr std::size_t kKinds = 9;
inline constexpr std::array<std::string_view, kKinds> kKindNames{"two_updates", "avatar_speed", "avatar_acceleration",
                                                                 "avatar_way",  "claim",        "body_speed",
                                                                 "body_spin",   "body_way",     "body_jump"};
inline constexpr std::array<std::string_view, kKinds> kKindUnits{"m", "m/s", "m/s^2", "m", "m", "m/s", "m/s", "m", "m"};

/// Something that a rule has measured.
struct Measure {
  Kind kind = Kind::kAvatarSpeed;
  float measured = 0;  ///< in the kind's unit
  float allowed = 0;   ///< likewise, margins included
  bool exceeds() const { return measured > allowed; }
  /// 1 at the limit.
  float share() const { return measured / (allowed > 0.001F ? allowed : 0.001F); }
  /// Something was measured: every rule allows more than nothing.
  bool is_set() const { return allowed > 0; }
};

/// Which of the two is nearer to its limit; one that is not set never is.
inline const Measure& nearer(const Measure& a, const Measure& b) {
  return b.is_set() && (!a.is_set() || b.share() > a.share()) ? b : a;
}

struct Finding {
  Kind kind = Kind::kTwoUpdates;
  MemberId who = 0;
  std::uint32_t index = 0;    ///< number of the update
  Tick tick = 0;              ///< of the update
  EntityId body = kNoEntity;  ///< kNoEntity: it is about the avatar, or about the update as a whole
  float measured = 0;         ///< in the kind's unit; of two updates: how far apart what they say is
  float allowed = 0;          ///< likewise, margins included
  /// The update bears the member's signature; of two updates: both do, which is proof.
  bool is_signed = false;
  PeerId passed_on_by = kNoPeer;    ///< of two updates: one of them only came from this peer, and may be its invention
  std::vector<std::size_t> traces;  ///< that it stands in, ascending
  std::string what;                 ///< in words
};

/// A body that was claimed as one that is pushed is: no contact, and a velocity from outside. Not a finding.
struct Push {
  MemberId who = 0;
  std::uint32_t index = 0;
  Tick tick = 0;
  EntityId body = 0;
  float speed = 0;                  ///< m/s
  bool recorded = false;            ///< the member's own trace says so
  std::vector<std::size_t> traces;  ///< ascending
};

}  // namespace padr::lab::audit
