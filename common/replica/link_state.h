#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/channel/replay_window.h"
#include "common/replica/link_clock.h"
#include "common/replica/one_way_delays.h"
#include "common/sync/delivery.h"
#include "common/sync/validation.h"

namespace padr::node {

/// The link with who sits in a slot: what is sent there and has come from there.
struct LinkState {
  sync::OutLink out;
  ReplayWindow window;
  LinkClock clock;
  Arrivals arrivals;
  std::uint32_t answered_seq = 0;  ///< of our newest datagram that it has said to have got
  std::uint32_t promised = 0;      ///< highest mark count heard
  bool repeats = false;            ///< it has sent again what is here: it has not heard so
  Tick checked = 0;                ///< when it was last told a hash
  Tick told_check = -1;            ///< of which tick
  std::vector<sync::Bundle> held;  ///< frozen: updates of it that are here beyond the first that is not

  std::array<std::uint64_t, sync::kDropReasons> dropped{};  ///< by reason, of whoever has sat there
  std::uint32_t cut_offs = 0;                               ///< how often who sits there now was given a deaf ear
};

}  // namespace padr::node
