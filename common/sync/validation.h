#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "common/model/scene.h"
#include "common/sync/fold.h"
#include "common/sync/packet.h"

namespace padr::sync {

/// Why something that a peer sent was dropped. Counted, never asserted.
enum class DropReason : std::uint8_t {
  kNone,
  kSeal,       ///< too short or long, wrong magic, version or tag
  kForeign,    ///< another session, or an address that is no member
  kMalformed,  ///< does not decode
  kDuplicate,  ///< a datagram that has been here already
  kTick,       ///< a tick outside what is believable now
  kOrder,      ///< updates whose numbers and ticks contradict one another or an earlier promise
  kEntity,     ///< no such body, or one told of twice
  kValue,      ///< not finite, outside the world, or faster than anything here can be
  kSignature,  ///< an update, passed on or not, that whoever it is said to be of has not signed
  kRight,      ///< an order of somebody who has no right to give it
  kCutOff,     ///< of a member that is not listened to any more, or not for now
  kPromise,    ///< an update of a tick up to which its peer had told this one that there is none any more
};
inline constexpr std::size_t kDropReasons = 13;
inline constexpr std::array<std::string_view, kDropReasons> kDropNames{
    "none",   "seal",  "foreign",   "malformed", "duplicate", "tick",   "order",
    "entity", "value", "signature", "right",     "cut_off",   "promise"};

/// Incarnations and numbers of updates are below this: counted one by one, they take years to get there.
inline constexpr std::uint32_t kEndOfNumbers = 1U << 30U;

/// Limits of what is believed: Box2D asserts, and so aborts, on what is not finite, and loses precision far out. World
/// keeps all that is within them there, so whatever an honest peer can come to is believed.
struct AdmitLimits {
  float margin = 20;           ///< m around the play area, kMostOutside and more: see around()
  float max_speed = 121;       ///< m/s; the scene may say less
  float max_spin = 95;         ///< rad/s, likewise
  float max_angle = 1.0e5F;    ///< rad
  float max_control = 1.0e4F;  ///< an avatar's target point, m, see believable_control, or acceleration, m/s^2
  Tick max_ahead = 120;        ///< ticks a sender's clock may lead ours
};

/// Whether a decoded packet of a session of so many slots, whose present tick is `now`, may be believed; kNone if so.
DropReason admit(const StatePacket& packet, const Scene& scene, int slots, Tick now, const AdmitLimits& limits = {});

/// The same of a single update, whose number and tick are another's to judge.
DropReason admit(const Bundle& bundle, const Scene& scene, int slots, const AdmitLimits& limits = {});
/// Whether nobody can have led its peer to its claims: their epochs are not far above what is agreed. No false claim
/// takes a record further than may_rest_on allows, however many an honest peer hears before they are found void.
DropReason admit_claims(const Bundle& bundle, const FoldState& confirmed);
/// Whether physics can take it.
bool believable(const BodyState& state, const Scene& scene, const AdmitLimits& limits = {});
/// The same of what AvatarUpdate::control says. A target point is measured from zero, in a region of a crowd from the
/// middle of the region: the plane has no end.
bool believable_control(Model model, Vec2 control, const Scene& scene, const AdmitLimits& limits = {});
/// The nearest target, m, of which nothing is told that others do not believe: it may be told as it will be in a while.
/// `target`: finite.
Vec2 believable_target(Vec2 target, const Scene& scene);

}  // namespace padr::sync
