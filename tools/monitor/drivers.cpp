#include "tools/monitor/drivers.h"

#include <algorithm>

#include "shell/path_csv.h"

namespace padr::monitor {

ViewerId Drivers::take(PeerId slot, ViewerId viewer, Micros now) {
  Driver& d = drivers_[slot];
  const ViewerId before = d.viewer == viewer ? 0 : d.viewer;
  d = {viewer, now};
  return before;
}

bool Drivers::release(PeerId slot, ViewerId viewer) {
  const auto found = drivers_.find(slot);
  if (found == drivers_.end() || found->second.viewer != viewer) return false;
  drivers_.erase(found);
  return true;
}

template <typename Fits>
std::vector<PeerId> Drivers::take_out(Fits fits) {
  std::vector<PeerId> slots;
  for (const auto& [slot, d] : drivers_)
    if (fits(d)) slots.push_back(slot);
  for (const PeerId s : slots) drivers_.erase(s);
  return slots;
}

std::vector<PeerId> Drivers::gone(ViewerId viewer) {
  return take_out([viewer](const Driver& d) { return d.viewer == viewer; });
}

std::vector<PeerId> Drivers::silent(Micros now) {
  return take_out([now](const Driver& d) { return now - d.heard > kLease; });
}

std::string_view Drivers::word(PeerId slot, ViewerId viewer, bool told) const {
  const auto found = drivers_.find(slot);
  if (found == drivers_.end()) return told ? "other" : "no";
  return found->second.viewer == viewer ? "you" : "other";
}

void DrivenPaths::take(PeerId slot, const Frame& frame) {
  if (!frame.driven) return;
  constexpr Tick kPause = kTicksPerSecond / 2;
  Driven& d = paths_[slot];
  if (d.points.size() >= kPoints) return;
  if (!d.points.empty()) {
    if (frame.tick <= d.last) return;
    d.length += std::min(frame.tick - d.last, kPause);
  }
  d.last = frame.tick;
  // To the microsecond: a sum of fractions, or a third of one, would have 17 digits.
  d.points.push_back({static_cast<double>(tick_start(d.length)) / kMicrosPerSecond, frame.target});
}

std::string DrivenPaths::csv(PeerId slot) const {
  const auto found = paths_.find(slot);
  if (found == paths_.end() || found->second.points.size() < 2) return "";
  return shell::write_path_csv(scenarios::Path(found->second.points));
}

}  // namespace padr::monitor
