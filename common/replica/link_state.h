#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/channel/replay_window.h"
#include "common/delivery/delivery.h"
#include "common/replica/link_clock.h"
#include "common/replica/one_way_delays.h"
#include "common/sync/validation.h"

namespace padr::node {

/// The link to the peer in a slot: what is sent to it and what has come from it.
struct LinkState {
  sync::OutLink out;
  ReplayWindow window;
  LinkClock clock;
  Arrivals arrivals;
  std::uint32_t answered_seq = 0;    ///< number of our newest datagram that it has acknowledged
  std::uint32_t promised = 0;        ///< highest mark count heard
  Tick promised_until = -1;          ///< latest tick of its marks
  std::uint32_t promised_below = 0;  ///< that mark's count: its updates of ticks up to then have lower numbers
  bool repeats = false;              ///< it repeated updates that are here: it lacks our acknowledgement
  Tick checked = 0;                  ///< when a hash for it was last due
  Tick told_check = -1;              ///< tick of the last hash sent to it
  std::vector<sync::Bundle> held;    ///< while frozen: its updates beyond the first missing one
  std::vector<sync::Bundle> orders;  ///< its updates that change the membership, by number, if one before is missing

  std::array<std::uint64_t, sync::kDropReasons> dropped{};  ///< by reason, of all peers that had the slot
  std::uint32_t cut_offs = 0;                               ///< how often its present peer was cut off or muted

  /// Smoothed round trip, us, for people: that of `out` is of whole ticks, which most datagrams take a little more
  /// than.
  Micros round_trip() const {
    return std::max(clock.round_trip(),
                    static_cast<Micros>(static_cast<double>(out.round_trip()) * 1e6 / kTicksPerSecond));
  }
};

}  // namespace padr::node
