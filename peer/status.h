#pragma once

#include <optional>
#include <string>

#include "peer/player.h"

namespace padr::peer {

/// Makes the status line: what happened since the last one, and how things stand.
class Status {
 public:
  std::string line(const Player& player, Micros now);

 private:
  Micros last_ = 0;
  std::uint64_t last_ticks_ = 0;
  std::uint64_t last_updates_ = 0;
  std::uint64_t last_bytes_ = 0;
  std::uint64_t last_replayed_ = 0;
};

/// Entity updates told so far, of all causes.
std::uint64_t updates_told(const node::ReplicaStats& stats);
/// What the link to that slot was found to carry, kbit/s; nothing if no limit was found.
std::optional<double> link_kbit(const node::Replica& replica, PeerId to);
/// Time that confirmed trails the present by, ms.
double confirmed_lag_ms(const Player& player);

}  // namespace padr::peer
