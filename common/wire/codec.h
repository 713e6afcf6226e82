#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/sync/packet.h"
#include "common/wire/seal.h"

namespace padr::wire {

/// Payload bytes of a state datagram. Ticks and indices must not lie beyond the packet's marks.
Bytes encode(const sync::StatePacket& packet);

/// The packet, if the bytes are well formed: columns of matching length, known causes and models, ids ascending, no
/// number out of its type's range. Whether what it says is believable is for sync::admit. `sender` goes into the
/// updates.
std::optional<sync::StatePacket> decode_state(std::span<const std::byte> payload, PeerId sender);

/// Payload bytes that one update adds to a datagram, an upper bound good to a few bytes: exact but for its distance
/// from the mark, which is taken to be below 2^21 updates and ticks. Any bundle of less than 2^28 ticks (51 days) fits
/// a datagram, passed on kMaxPassing times, too.
std::size_t encoded_size(const sync::Bundle& bundle);
/// Payload bytes of everything else in a state datagram at most.
inline constexpr std::size_t kStateOverhead = 76;

}  // namespace padr::wire
