#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/sync/updates.h"

namespace padr::wire {

/// What counting takes of a state datagram; decode_state has everything. Meant to be used again for the next datagram:
/// then nothing is allocated.
struct StateScan {
  struct Update {
    std::uint32_t index = 0;
    std::uint32_t tick = 0;
    std::array<std::uint8_t, sync::kCauses> causes{};  ///< entity updates by cause; an update passed on has none here
    bool leave = false;
    bool order = false;       ///< admission, removals, or an update passed on
    std::uint32_t bytes = 0;  ///< of the payload, key and length included
  };
  std::uint32_t seq = 0;
  std::uint32_t mark_tick = 0;
  std::uint32_t mark_count = 0;
  std::uint32_t have = 0;
  std::uint32_t have_beyond = 0;
  std::uint32_t seen_seq = 0;
  std::uint32_t seen_age = 0;
  std::int32_t transit = 0;
  std::uint32_t check_age = 0;
  std::uint32_t check_hash = 0;
  std::uint32_t loss = 0;
  std::uint32_t incarnation = 0;
  std::uint32_t to_incarnation = 0;
  std::vector<Update> updates;

 private:
  friend bool scan_state(std::span<const std::byte> payload, StateScan& out);
  std::vector<std::span<const std::byte>> raw_;  ///< updates, until the mark is known
};

/// Reads the payload of a state datagram without the generated code, several times as fast. False if it is malformed;
/// whatever decode_state takes is taken, and comes out the same. What is wrong with an update beyond its numbers, ticks
/// and causes is not looked for.
bool scan_state(std::span<const std::byte> payload, StateScan& out);

}  // namespace padr::wire
