#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "common/model/own_address.h"
#include "common/sync/updates.h"
#include "common/wire/seal.h"

namespace padr::wire {

// What peers of a running session say about who is there, as plain structs; proto/wire.proto says who says what to
// whom.

struct Pull {
  std::uint64_t nonce = 0;
  std::uint32_t from = 0;    ///< below kMaxPieces
  std::uint64_t wanted = 0;  ///< bit i: piece from+i
  std::uint64_t cookie = 0;  ///< of the Welcome, not 0
  friend bool operator==(const Pull&, const Pull&) = default;
};

struct Piece {
  std::uint64_t nonce = 0;
  std::uint32_t index = 0;  ///< below count
  std::uint32_t count = 0;  ///< 1 .. kMaxPieces
  Bytes bytes;              ///< 1 .. kPieceBytes
  friend bool operator==(const Piece&, const Piece&) = default;
};

struct Enter {
  std::uint64_t nonce = 0;
  friend bool operator==(const Enter&, const Enter&) = default;
};

struct Seat {
  PeerId slot = kNoPeer;  ///< below kMaxPeers
  std::uint32_t incarnation = 0;
  std::uint32_t have = 0;
  /// In an Answer: 1 + how many ticks before its tick the newest mark is by which the slot's peer has answered the
  /// sender, kMostHeard at most; 0: there is none.
  std::uint32_t heard = 0;
  friend bool operator==(const Seat&, const Seat&) = default;
};

/// Who asks and who answers are not among the lost.
inline constexpr std::size_t kMostLost = kMaxPeers - 2;
inline constexpr std::uint32_t kMostHeard = 0x3FFF;
inline constexpr std::uint32_t kMostPollNumber = 0x3FFF;

struct Poll {
  std::vector<Seat> lost;  ///< 1 .. kMostLost, by ascending slot
  bool freeze = false;     ///< take nothing more from them; otherwise it is only asked who hears them
  /// Takes back what the sender has asked with a lower number.
  std::uint32_t number = 0;  ///< at most kMostPollNumber
  friend bool operator==(const Poll&, const Poll&) = default;
};

struct Answer {
  std::vector<Seat> lost;    ///< 1 .. kMostLost, by ascending slot
  bool frozen = false;       ///< as the Poll that is answered
  Tick tick = 0;             ///< of the sender
  std::uint32_t number = 0;  ///< as the Poll that is answered
  friend bool operator==(const Answer&, const Answer&) = default;
};

struct Fetch {
  PeerId slot = kNoPeer;  ///< below kMaxPeers
  std::uint32_t incarnation = 0;
  std::uint32_t from = 0;
  friend bool operator==(const Fetch&, const Fetch&) = default;
};

struct Fetched {
  PeerId slot = kNoPeer;  ///< below kMaxPeers
  std::uint32_t incarnation = 0;
  std::vector<sync::Bundle> updates;  ///< of the slot, by number and tick, at least one
  friend bool operator==(const Fetched&, const Fetched&) = default;
};

struct Probe {
  std::uint32_t incarnation = 0;
  std::vector<Seat> members;  ///< 1 .. kMaxPeers, by ascending slot
  bool knows_you = false;
  std::uint32_t newest = 0;  ///< the highest incarnation heard of
  bool yields = false;       ///< the sender is about to join another part
  friend bool operator==(const Probe&, const Probe&) = default;
};

struct Way {
  PeerId slot = kNoPeer;    ///< below kMaxPeers
  std::uint32_t delay = 0;  ///< one way, ticks, at most kMostDelay
  bool carried = false;     ///< it is heard only by others
  friend bool operator==(const Way&, const Way&) = default;
};

inline constexpr std::uint32_t kMostDelay = 0x3FFF;

struct Reach {
  Tick tick = 0;               ///< of the sender
  std::vector<Way> heard;      ///< whom the sender hears; at most kMaxPeers, by ascending slot
  std::vector<Endpoint> at{};  ///< the sender's own addresses, as it has them; kMostOwnAddresses, without keys
  friend bool operator==(const Reach&, const Reach&) = default;
};

struct Newcomer {
  Endpoint at;  ///< set
  friend bool operator==(const Newcomer&, const Newcomer&) = default;
};

using MembershipMessage = std::variant<Pull, Piece, Enter, Poll, Answer, Fetch, Fetched, Probe, Reach, Newcomer>;

inline constexpr std::uint32_t kMaxPieces = 2048;
inline constexpr std::size_t kPieceBytes = kMaxPayload - 40;

/// Payload bytes. A Fetched takes as many of its updates, from the first on, as fit a datagram and ascend by
/// number and tick: a peer may have told updates beyond a missing one whose numbers contradict their ticks.
Bytes encode_membership(const MembershipMessage& message);
/// The message, if the bytes are well formed and every value is in the range that its struct states.
std::optional<MembershipMessage> decode_membership(std::span<const std::byte> payload);

}  // namespace padr::wire
