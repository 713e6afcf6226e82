#include "tools/capture/world_check.h"

#include <algorithm>

namespace padr::capture {
namespace {

/// Whether a peer gave up this world of this tick for another incarnation: the capture may be its own. The datagrams in
/// it tell that world further than the peer had confirmed it when it gave it up.
bool gave_up(const TraceStory& t, Tick tick, const RebuiltWorld& w, const RebuiltWorlds& rebuilt) {
  if (!t.superseded || t.confirmed.empty()) return false;
  if (const auto found = t.confirmed.find(tick); found != t.confirmed.end()) return found->second == w.hash;
  const auto& [last, hash] = *t.confirmed.rbegin();
  if (tick < last || std::find(w.given_up.begin(), w.given_up.end(), t.who()) == w.given_up.end()) return false;
  const auto known = rebuilt.find(last);
  return known != rebuilt.end() && known->second.hash == hash;
}

}  // namespace

std::vector<WorldCheck> check_worlds(const RebuiltWorlds& rebuilt, const std::vector<TraceStory>& traces) {
  std::vector<WorldCheck> out;
  for (const TraceStory& t : traces) {
    WorldCheck c;
    c.label = t.label;
    c.superseded = t.superseded;
    for (const auto& [tick, hash] : t.confirmed) {
      const auto ours = rebuilt.find(tick);
      if (ours == rebuilt.end()) {
        ++c.beyond;
        continue;
      }
      const bool alike = ours->second.hash == hash;
      if (!alike && std::any_of(traces.begin(), traces.end(), [&, tick = tick](const TraceStory& other) {
            return gave_up(other, tick, ours->second, rebuilt);
          })) {
        ++c.given_up;
        continue;
      }
      ++c.compared;
      c.last = tick;
      if (alike) {
        ++c.alike;
      } else if (c.first_difference < 0) {
        c.first_difference = tick;
      }
    }
    out.push_back(c);
  }
  return out;
}

}  // namespace padr::capture
