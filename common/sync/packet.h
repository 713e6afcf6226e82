#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/sync/updates.h"

namespace padr::sync {

/// What one state datagram says, besides who sent it: WIRE.md's State.
struct StatePacket {
  std::uint32_t seq = 0;
  std::uint32_t incarnation = 0;     ///< of the sender in its slot
  std::uint32_t to_incarnation = 0;  ///< of the receiver in its own
  Tick mark_tick = 0;
  std::uint32_t mark_count = 0;
  std::uint32_t have = 0;
  std::uint32_t have_beyond = 0;
  std::uint32_t seen_seq = 0;
  std::uint32_t seen_age = 0;   ///< ticks
  std::int32_t transit = 0;     ///< 0.1 ms; 0: not told
  std::uint32_t loss = 0;       ///< per cent of the receiver's recent datagrams that were lost
  std::vector<Bundle> updates;  ///< `peer` is not on the wire; the receiver fills in the sender
  Tick check_tick = -1;         ///< -1: no hash
  std::uint32_t check_hash = 0;
  friend bool operator==(const StatePacket&, const StatePacket&) = default;
};

}  // namespace padr::sync
