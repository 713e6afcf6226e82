#pragma once

#include "common/trace/fidelity.h"
#include "common/trace/physics_consistency_cost.h"
#include "common/trace/shown_meter.h"
#include "shell/json.h"

namespace padr::shell {

/// Fields of an open object; padr-lab and padr-report give a measure the same names. docs/metrics.md defines them.
inline void put(Json& j, const trace::Fidelity& f) {
  j.field("fidelity_mean_m", f.mean_m).field("fidelity_own_mean_m", f.own_mean_m);
  j.field("fidelity_others_mean_m", f.others_mean_m).field("fidelity_nobody_mean_m", f.nobody_mean_m);
  j.field("fidelity_p95_m", f.p95_m).field("fidelity_peak_m", f.peak_m);
}

inline void put(Json& j, const trace::Pcc& c) {
  j.field("pcc_mean_m", c.mean_m).field("pcc_peak_m", c.peak_m);
  j.field("pcc_bodies_mean", c.bodies_mean).field("pcc_bodies_peak", c.bodies_peak);
}

inline void put(Json& j, const trace::ShownMotion& s) {
  j.field("stride_change_m_per_s", s.stride_change_m_per_s());
  j.field("stride_unexplained_m_per_s", s.unexplained_m_per_s());
  j.field("stops", s.stops).field("overshoot_mean_m", s.overshoot_mean_m());
  j.field("overshoot_peak_m", s.overshoot_peak_m);
  j.field("overlap_mean_m", s.overlap_mean_m()).field("overlap_made_mean_m", s.overlap_made_mean_m());
  j.field("overlap_peak_m", s.overlap_peak_m);
  j.field("freezes_per_s", s.freezes_per_s()).field("longest_freeze_s", s.longest_freeze_s());
}

}  // namespace padr::shell
