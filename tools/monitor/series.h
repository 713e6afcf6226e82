#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "common/sync/updates.h"
#include "common/trace/metrics.h"

namespace padr::monitor {

/// One moment of one peer, for plots. What is not known is not there.
struct PeerPoint {
  PeerId slot = kNoPeer;
  std::optional<trace::InconsistencyPoint>
      inconsistency;                ///< mean since the last moment, else held; its tick is the newest
  std::optional<float> fidelity_m;  ///< mean fidelity error since the last moment; of recordings only
  std::optional<float> pcc_m;       ///< mean physics-consistency-cost of its avatar since the last moment; likewise
  std::optional<std::array<float, sync::kCauses>> updates_per_s;
  float kbit_per_s = 0;  ///< with updates_per_s
  std::optional<float> lag_ms;
  std::optional<float> threshold_m;
  std::vector<std::pair<PeerId, float>> delay_ms;  ///< median of what comes from there
};

struct SeriesPoint {
  Tick tick = 0;
  std::vector<PeerPoint> peers;  ///< by ascending slot
};

/// The moments of the last hour: all of the last minutes, fewer of those before, so that memory stays flat.
class Series {
 public:
  void add(SeriesPoint p);
  const std::deque<SeriesPoint>& points() const { return points_; }
  void clear() { points_.clear(); }

 private:
  void thin(Tick now);
  std::deque<SeriesPoint> points_;
  std::size_t added_ = 0;
};

}  // namespace padr::monitor
