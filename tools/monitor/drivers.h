#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/monitor/telemetry.h"
#include "common/scenarios/path.h"
#include "shell/path_csv.h"
#include "tools/monitor/site.h"

namespace padr::monitor {

/// Who of the viewers drives whom.
class Drivers {
 public:
  /// A viewer drives the slot from now on, or still does. Whom it took it from; 0: nobody.
  ViewerId take(PeerId slot, ViewerId viewer, Micros now);
  /// False if the viewer does not drive it.
  bool release(PeerId slot, ViewerId viewer);
  /// Slots that are driven no more: the viewer has gone, or has said nothing for too long.
  std::vector<PeerId> gone(ViewerId viewer);
  std::vector<PeerId> silent(Micros now);
  void clear() { drivers_.clear(); }

  /// As page/PROTOCOL.md has it. `told`: the peer says that it is driven.
  std::string_view word(PeerId slot, ViewerId viewer, bool told) const;

  static constexpr Micros kLease = kMicrosPerSecond;

 private:
  struct Driver {
    ViewerId viewer = 0;
    Micros heard = 0;
  };
  /// The slots of drivers that fit, who drive no more.
  template <typename Fits>
  std::vector<PeerId> take_out(Fits fits);

  std::map<PeerId, Driver> drivers_;
};

/// Where avatars were driven to from pages, to be saved as a path.
class DrivenPaths {
 public:
  /// A new frame of who sits in the slot.
  void take(PeerId slot, const Frame& frame);
  void clear() { paths_.clear(); }
  /// What shell::parse_path_csv reads; empty if there are no two points. Times from 0, pauses in driving left out.
  std::string csv(PeerId slot) const;

  static constexpr std::size_t kPoints = 100'000;  ///< kept of one avatar, from the first: an hour and a half at 20 Hz

 private:
  struct Driven {
    std::vector<scenarios::PathPoint> points;
    Tick last = 0;
    Tick length = 0;  ///< without pauses
  };
  std::map<PeerId, Driven> paths_;
};

}  // namespace padr::monitor
