#include "tools/lab/rates.h"

#include <algorithm>

namespace padr::lab {

Rates rates_of(const Simulation& s, PeerId from, int n) {
  Rates r;
  const double seconds = static_cast<double>(s.now()) / kTicksPerSecond * n;
  for (int i = 0; i < n; ++i) {
    const node::Replica& replica = s.replica(static_cast<PeerId>(from + i));
    const node::ReplicaStats& st = replica.stats();
    for (std::size_t c = 0; c < sync::kCauses; ++c) {
      r.by_cause[c] += static_cast<double>(st.updates_by_cause[c]) / seconds;
      r.updates += static_cast<double>(st.updates_by_cause[c]) / seconds;
    }
    r.datagrams += static_cast<double>(st.datagrams_sent) / seconds;
    r.kbps += static_cast<double>(st.wire_bytes_sent) * 8 / 1000 / seconds;
    r.repeats += static_cast<double>(st.repeats) / seconds;
    r.replay_steps_per_tick += static_cast<double>(replica.agreed().replayed_steps()) / seconds / kTicksPerSecond;
    r.lookahead_steps_per_tick += static_cast<double>(replica.lookahead_steps()) / seconds / kTicksPerSecond;
    r.snaps += static_cast<double>(replica.shown().snaps()) / seconds;
    r.snap_m += replica.shown().snap_metres() / seconds;
    r.snap_peak_m = std::max(r.snap_peak_m, replica.shown().largest_snap());
    r.shown.add(s.shown(static_cast<PeerId>(from + i)));
    r.hash_mismatches += st.hash_mismatches;
  }
  return r;
}

}  // namespace padr::lab
