#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/wire/seal.h"

namespace padr::wire {

// What peers say to come together, as plain structs; proto/wire.proto says who says what to whom.

struct Join {
  std::uint64_t nonce = 0;  ///< not 0
  std::uint64_t scene_hash = 0;
  std::uint64_t fingerprint = 0;
  bool authority = true;
  std::string scenario;  ///< at most kMaxLabel bytes
  friend bool operator==(const Join&, const Join&) = default;
};

struct Welcome {
  std::uint64_t nonce = 0;
  PeerId peer = kNoPeer;          ///< 1 .. wanted-1 before the start
  int slots = 0;                  ///< wanted .. kMaxPeers
  int wanted = 0;                 ///< 1 .. slots
  bool running = false;           ///< the session runs already; `peer` is below slots
  std::uint32_t incarnation = 0;  ///< of the newcomer in its slot: not 0 if running, 0 otherwise
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

struct Redirect {
  std::uint64_t nonce = 0;
  Endpoint founder;  ///< set
  friend bool operator==(const Redirect&, const Redirect&) = default;
};

struct Refuse {
  std::uint64_t nonce = 0;  ///< 0: to whoever it was that spoke another protocol version
  std::string reason;       ///< at most kMaxReason bytes
  friend bool operator==(const Refuse&, const Refuse&) = default;
};

struct Ping {
  Micros sent = 0;
  friend bool operator==(const Ping&, const Ping&) = default;
};

struct Pong {
  Micros sent = 0;
  Micros founder = 0;
  int present = 0;  ///< 0 .. kMaxPeers
  friend bool operator==(const Pong&, const Pong&) = default;
};

/// Who is where, by peer number. The founder's entry is not set: it is where the datagram came from.
using Roster = std::vector<Endpoint>;

/// Some of the members at tick 0, as all of them may be more than fit a datagram.
struct Start {
  Micros tick0 = 0;
  Roster members;    ///< 1 .. kMaxPeers - first, all set but the founder's
  PeerId first = 0;  ///< peer number of the first of them; the others' follow
  friend bool operator==(const Start&, const Start&) = default;
};

struct Ready {
  Micros round_trip = 0;  ///< 0 .. 2^32-1
  bool started = false;
  friend bool operator==(const Ready&, const Ready&) = default;
};

struct Bye {
  std::string reason;  ///< at most kMaxReason bytes
  friend bool operator==(const Bye&, const Bye&) = default;
};

using SessionMessage = std::variant<Join, Welcome, Redirect, Refuse, Ping, Pong, Start, Ready, Bye>;

/// So many members, even with public keys, fit a Start.
inline constexpr std::size_t kMembersPerStart = 20;
inline constexpr std::size_t kMaxLabel = 128;
inline constexpr std::size_t kMaxReason = 400;
/// Times on anybody's clock lie within this of zero (285 years), so that sums and differences of two never overflow.
inline constexpr Micros kMaxClock = Micros{1} << 53U;

/// Payload bytes. Texts that are too long are cut; a Join is padded to kMaxPayload, a Ping to no less than its Pong.
Bytes encode_session(const SessionMessage& message);

/// The message, if the bytes are well formed and every value is in the range that its struct states. Texts come out
/// printable: whatever is not ASCII between space and tilde is replaced by '?', as they end up in logs.
std::optional<SessionMessage> decode_session(std::span<const std::byte> payload);

}  // namespace padr::wire
