#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/sync/packet.h"
#include "common/wire/seal.h"

namespace padr::wire {

class State;

/// Writes state datagrams, one after another: what one took up is there for the next, so that nothing is allocated any
/// more.
class StateEncoder {
 public:
  StateEncoder();
  ~StateEncoder();
  StateEncoder(StateEncoder&&) noexcept;

  /// Payload bytes, good until the next call. Ticks and indices must not lie beyond the packet's marks.
  std::span<const std::byte> encode(const sync::StatePacket& packet);

 private:
  std::unique_ptr<State> message_;
  Bytes bytes_;
};

/// Reads them likewise; only orders, which are few, are allocated for each time.
class StateDecoder {
 public:
  StateDecoder();
  ~StateDecoder();
  StateDecoder(StateDecoder&&) noexcept;

  /// The packet, good until the next call, if the bytes are well formed: columns that are used up, known causes and
  /// models, no number out of its type's range; otherwise null. Whether what it says is believable is for sync::admit.
  /// `sender` goes into the updates.
  const sync::StatePacket* decode(std::span<const std::byte> payload, PeerId sender);

 private:
  bool take(PeerId sender);

  std::unique_ptr<State> message_;
  sync::StatePacket packet_;
  std::vector<sync::Bundle> spare_;  ///< of packets that had more updates
};

/// The same for one alone.
Bytes encode(const sync::StatePacket& packet);
std::optional<sync::StatePacket> decode_state(std::span<const std::byte> payload, PeerId sender);

/// Payload bytes that one update adds to a datagram, an upper bound good to a few bytes: exact but for its distance
/// from the mark, which is taken to be below 2^21 updates and ticks. Any bundle of less than 2^28 ticks (51 days) fits
/// a datagram, passed on kMaxPassing times, too.
std::size_t encoded_size(const sync::Bundle& bundle);
/// Payload bytes of everything else in a state datagram at most.
inline constexpr std::size_t kStateOverhead = 66;

}  // namespace padr::wire
