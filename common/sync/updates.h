#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/state.h"
#include "common/model/technique.h"

namespace padr::sync {

/// Why an update was sent; counted by every report.
enum class Cause : std::uint8_t {
  kThreshold,      ///< an avatar's model error exceeded the threshold
  kContactBegin,   ///< the avatar began to touch a body
  kContactEnd,     ///< it let go
  kProxy,          ///< a body joined or left the chain of contacts
  kBodyThreshold,  ///< a body's error exceeded the body threshold
  kAtRest,         ///< it came to rest: the exact final state
  kLeave,          ///< the avatar left
};
inline constexpr std::size_t kCauses = 7;
inline constexpr std::array<std::string_view, kCauses> kCauseNames{
    "threshold", "contact_begin", "contact_end", "proxy", "body_threshold", "at_rest", "leave"};

/// An avatar's state, the same for all to the bit, and what its model needs besides.
struct AvatarUpdate {
  Cause cause = Cause::kThreshold;
  Vec2 position;  ///< m
  Vec2 velocity;  ///< m/s
  bool awake = true;
  Model model = Model::kFirst;
  Vec2 control;  ///< target point in m (input model), acceleration in m/s^2 (second order), else unused
  friend bool operator==(const AvatarUpdate&, const AvatarUpdate&) = default;
};

/// What a peer says of one body: that its avatar holds it or no longer does, and, as its owner, its state.
struct BodyUpdate {
  EntityId body = 0;
  Cause cause = Cause::kThreshold;
  bool held = false;        ///< the sender's avatar touches the body
  bool has_state = false;   ///< otherwise the predicted state is right, and only the flags are told
  bool release = false;     ///< the sender gives its authority up
  BodyState state;          ///< if has_state
  std::uint32_t epoch = 0;  ///< if has_state: of the authority this rests on
  Tick claimed = 0;         ///< if has_state: tick of the claim of that epoch
  friend bool operator==(const BodyUpdate&, const BodyUpdate&) = default;
};

/// A peer comes in: from this tick on its avatar is there, and its updates count.
struct Admission {
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 1;  ///< of the slot; 0 are those who were there at tick 0
  std::uint32_t first = 0;        ///< number of its first update: a slot's numbers go on from one peer to the next
  Endpoint at;
  std::vector<std::uint32_t> have;  ///< by slot: it has that slot's updates below this
  bool spectator = false;           ///< it has no avatar
  friend bool operator==(const Admission&, const Admission&) = default;
};

/// A peer that fell silent is out: its updates from `count` on never happened, its avatar goes.
struct Removal {
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 0;
  std::uint32_t count = 0;
  friend bool operator==(const Removal&, const Removal&) = default;
};

/// Which body of a crowd: where it began, and its number there.
struct BodyName {
  std::uint32_t region = 0;
  std::uint16_t number = 0;
  friend auto operator<=>(const BodyName&, const BodyName&) = default;
};

/// A step of a body on its way from this region of a crowd to another, or from another to this one.
struct Passage {
  enum class Kind : std::uint8_t {
    kBound,  ///< it is bound for region `to`, and for no other; the first such word counts
    kIn,     ///< it comes in
    kOut,    ///< it is in the other region now: it goes out
  };
  Kind kind = Kind::kBound;
  BodyName name;
  std::uint32_t crossings = 1;  ///< that it will have made, or has made, with this one
  std::uint32_t to = 0;         ///< kBound
  // Of one that comes in:
  std::uint8_t build = 0;
  bool owned = false;  ///< the sender goes on owning it
  BodyState state;
  friend bool operator==(const Passage&, const Passage&) = default;
};

/// Ed25519.
using Signature = std::array<std::byte, 64>;

/// All that one peer tells of one tick: the unit of the log, of acknowledgement and of repair.
struct Bundle {
  PeerId peer = kNoPeer;
  std::uint32_t index = 0;  ///< 0, 1, 2, ... in the sender's log
  Tick tick = 0;            ///< at which every state in it is true, before the step to the next
  bool leave = false;       ///< the sender's last bundle: its avatar goes
  bool spectates = false;   ///< in an update of its own: the sender's avatar goes, the sender stays as a spectator
  std::optional<AvatarUpdate> avatar;
  std::vector<BodyUpdate> bodies;  ///< by ascending body id, each once
  // What only the coordinator says, each in an update of its own:
  std::optional<Admission> admission;
  std::vector<Removal> removals;  ///< who is declared gone together goes at the same tick
  std::vector<Bundle> passed_on;  ///< at most one: an update of a lost peer that somebody may lack, without such a one
  std::optional<bool>
      going;  ///< of a region of a crowd, in an update of its own: the sender wants to leave, or no longer
  std::vector<Passage> passages;       ///< of a region of a crowd; in an update of their own, kMaxPassages at most
  std::optional<Signature> signature;  ///< in a session with a key: of its peer, over all of it; see wire/signature.h
  friend bool operator==(const Bundle&, const Bundle&) = default;
};

/// Bodies one bundle may carry, so that any bundle fits a datagram, passed on by kMaxPassing peers in turn, too; a
/// larger set goes out over several ticks.
inline constexpr std::size_t kMaxBodiesPerBundle = 27;
/// The same if it is signed, and those that pass it on are.
inline constexpr std::size_t kMaxBodiesPerSigned = 20;

/// Bodies that may cross a border in one update.
inline constexpr std::size_t kMaxPassages = 8;

/// How deep updates may lie in updates: every coordinator that is lost while it passes on adds one.
inline constexpr int kMaxPassing = 3;

}  // namespace padr::sync
