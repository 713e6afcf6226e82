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
  bool spectator = false;
  friend bool operator==(const Join&, const Join&) = default;
};

struct Welcome {
  std::uint64_t nonce = 0;
  PeerId peer = kNoPeer;          ///< below slots
  int slots = 0;                  ///< wanted .. kMaxPeers
  int wanted = 0;                 ///< members that play waits, or waited, for: 1 .. slots
  std::uint32_t incarnation = 0;  ///< of the newcomer in its slot, not 0
  std::uint64_t cookie = 0;       ///< to be said with every Pull, not 0
  SessionId session{};            ///< all zeros in a session without a key
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

struct Redirect {
  std::uint64_t nonce = 0;
  Endpoint to;  ///< set
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
  Micros session = 0;  ///< session time
  friend bool operator==(const Pong&, const Pong&) = default;
};

/// Which regions of a crowd somebody is in, and which ones it looks for, by their numbers: no more than kMostRegions
/// each, none 0. docs/crowds.md says what for.
struct Whereabouts {
  std::vector<std::uint32_t> in{};
  std::vector<std::uint32_t> seeks{};
  friend bool operator==(const Whereabouts&, const Whereabouts&) = default;
};

struct Ask {
  std::uint64_t nonce = 0;  ///< not 0
  std::uint64_t crowd = 0;
  std::uint32_t about = 0;  ///< not 0
  Whereabouts sender;
  std::uint32_t rank = 0;
  friend bool operator==(const Ask&, const Ask&) = default;
};

struct Acquaintance {
  Endpoint at;  ///< set, without a key
  Whereabouts where;
  friend bool operator==(const Acquaintance&, const Acquaintance&) = default;
};

struct Tell {
  std::uint64_t nonce = 0;  ///< not 0
  std::uint64_t crowd = 0;
  std::uint32_t about = 0;  ///< not 0
  Whereabouts sender;
  std::uint32_t rank = 0;
  Micros clock = 0;                   ///< 0 .. kMaxClock; 0: it has none yet
  std::vector<Acquaintance> known{};  ///< kMostKnown at most
  bool noted = false;                 ///< from now on others are told where the asker is and what it looks for
  friend bool operator==(const Tell&, const Tell&) = default;
};

using SessionMessage = std::variant<Join, Welcome, Redirect, Refuse, Ping, Pong, Ask, Tell>;

inline constexpr std::size_t kMostRegions = 8;
inline constexpr std::size_t kMostKnown = 16;
/// Of every Ask.
inline constexpr std::size_t kAskPayload = 256;

inline constexpr std::size_t kMaxLabel = 128;
inline constexpr std::size_t kMaxReason = 400;
/// Times on anybody's clock lie within this of zero (285 years), so that sums and differences of two never overflow.
inline constexpr Micros kMaxClock = Micros{1} << 53U;

/// Payload bytes. Texts that are too long are cut; a Join is padded to kMaxPayload, an Ask to kAskPayload, a Ping to no
/// less than its Pong.
Bytes encode_session(const SessionMessage& message);
/// A Tell of no more than `most` payload bytes, with as many of those known, from the first on, as there is room for;
/// nothing if there is none without any.
std::optional<Bytes> encode_tell_within(const Tell& tell, std::size_t most);

/// The message, if the bytes are well formed and every value is in the range that its struct states. Texts come out
/// printable: whatever is not ASCII between space and tilde is replaced by '?', as they end up in logs.
std::optional<SessionMessage> decode_session(std::span<const std::byte> payload);

}  // namespace padr::wire
