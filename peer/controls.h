#pragma once

#include <optional>
#include <string>

#include "common/monitor/orders.h"
#include "peer/egress.h"
#include "peer/link_cuts.h"
#include "peer/log.h"
#include "peer/player.h"
#include "peer/telemetry.h"

namespace padr::peer {

/// Does what a monitor orders, and says so: in the log, in the trace and to the monitor.
class Controls {
 public:
  /// All must outlive it.
  Controls(Player& player, Egress& egress, LinkCuts& cuts, Telemetry& telemetry, Log& log)
      : player_(player), egress_(egress), cuts_(cuts), telemetry_(telemetry), log_(log) {}

  void obey(const monitor::Order& order, Micros now);
  /// Ends what was ordered for a while and is over by `now`.
  void update(Micros now);

 private:
  void follow(const monitor::Drive& d, std::uint32_t order, Micros now);
  void follow(const monitor::Knob& k, std::uint32_t order, Micros now);
  void follow(const monitor::Netem& n, std::uint32_t order, Micros now);
  void follow(const monitor::Cut& c, std::uint32_t order, Micros now);
  void follow(const monitor::Pause& p, std::uint32_t order, Micros now);
  void follow(const monitor::Push& p, std::uint32_t order, Micros now);
  /// The number of another peer that was ordered; nothing for all. Throws UserError if nobody is there.
  std::optional<PeerId> other(PeerId p) const;
  void say(monitor::EventKind kind, std::uint32_t order, PeerId peer, const std::string& text,
           EntityId entity = kNoEntity);

  Player& player_;
  Egress& egress_;
  LinkCuts& cuts_;
  Telemetry& telemetry_;
  Log& log_;
  Micros now_ = 0;
  bool was_paused_ = false;
  RateLimit limit_;
};

}  // namespace padr::peer
