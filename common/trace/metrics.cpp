#include "common/trace/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace padr::trace {
namespace {

double percentile(std::vector<float>& sorted, double p) {
  if (sorted.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(sorted.size())));
  return static_cast<double>(sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1]);
}

}  // namespace

InconsistencyMeter::InconsistencyMeter(int peers, int bodies)
    : InconsistencyMeter(
          [peers] {
            std::vector<PeerId> slots(static_cast<std::size_t>(peers));
            std::iota(slots.begin(), slots.end(), PeerId{0});
            return slots;
          }(),
          bodies) {}

InconsistencyMeter::InconsistencyMeter(std::vector<PeerId> slots, int bodies)
    : bodies_(bodies),
      slots_(std::move(slots)),
      came_at_(slots_.size(), 0),
      gone_from_(slots_.size(), std::numeric_limits<Tick>::max()),
      series_(slots_.size()) {}

void InconsistencyMeter::view(std::size_t viewer, Tick tick, View v) {
  pending_[tick].views[viewer] = std::move(v);
  settle(tick);
}

void InconsistencyMeter::gone(std::size_t viewer, Tick from) {
  gone_from_[viewer] = std::min(gone_from_[viewer], from);
  std::vector<Tick> ticks;
  for (const auto& [tick, p] : pending_)
    if (tick >= from) ticks.push_back(tick);
  for (const Tick t : ticks) settle(t);
}

void InconsistencyMeter::truth(Tick tick, Truth t) {
  Pending& p = pending_[tick];
  p.has_truth = true;
  p.truth = std::move(t);
  settle(tick);
}

bool InconsistencyMeter::ready(Tick tick, const Pending& p) const {
  if (!p.has_truth) return false;
  for (std::size_t v = 0; v < slots_.size(); ++v)
    if (tick >= came_at_[v] && tick < gone_from_[v] && !p.views.contains(v)) return false;
  return true;
}

void InconsistencyMeter::settle(Tick tick) {
  const auto found = pending_.find(tick);
  if (found == pending_.end() || !ready(tick, found->second)) return;
  measure(tick, found->second);
  pending_.erase(found);
}

InconsistencyPoint inconsistency_of(const View& view, const std::vector<const View*>& by_slot, const Truth& truth,
                                    int bodies, Tick tick) {
  InconsistencyPoint point;
  point.tick = tick;
  for (std::size_t e = 0; e < truth.owner.size(); ++e) {
    if (!truth.present[e]) continue;
    const PeerId owner = truth.owner[e];
    const View* owners = owner == kNoPeer ? nullptr : by_slot[owner];
    const Vec2 there = owners != nullptr ? owners->live[e] : truth.agreed[e];
    const float error = distance(view.live[e], there);
    (e < static_cast<std::size_t>(bodies) ? point.bodies_m : point.avatars_m) += error;
    point.shown_m += distance(view.shown[e], there);
  }
  return point;
}

void InconsistencyMeter::measure(Tick tick, const Pending& p) {
  std::vector<const View*> by_slot(kMaxPeers, nullptr);
  for (const auto& [viewer, view] : p.views) by_slot[slots_[viewer]] = &view;
  for (const auto& [viewer, view] : p.views) {
    if (tick >= gone_from_[viewer]) continue;
    series_[viewer].push_back(inconsistency_of(view, by_slot, p.truth, bodies_, tick));
  }
}

Inconsistency summarize(const InconsistencySeries& series) {
  Inconsistency r;
  r.ticks = series.size();
  if (series.empty()) return r;
  std::vector<float> combined;
  combined.reserve(series.size());
  for (const InconsistencyPoint& p : series) {
    combined.push_back(p.combined());
    r.avatar_mean_m += static_cast<double>(p.avatars_m);
    r.body_mean_m += static_cast<double>(p.bodies_m);
    r.shown_mean_m += static_cast<double>(p.shown_m);
    r.shown_peak_m = std::max(r.shown_peak_m, static_cast<double>(p.shown_m));
  }
  const auto n = static_cast<double>(series.size());
  r.area_ms = (r.avatar_mean_m + r.body_mean_m) / kTicksPerSecond;
  r.avatar_mean_m /= n;
  r.body_mean_m /= n;
  r.shown_mean_m /= n;
  r.mean_m = r.avatar_mean_m + r.body_mean_m;
  r.final_m = static_cast<double>(combined.back());
  std::sort(combined.begin(), combined.end());
  r.p95_m = percentile(combined, 0.95);
  r.p99_m = percentile(combined, 0.99);
  r.peak_m = static_cast<double>(combined.back());
  return r;
}

Inconsistency InconsistencyMeter::result(std::size_t viewer) const {
  return summarize(series_[viewer]);
}

Inconsistency summarize_all(const std::vector<InconsistencySeries>& series) {
  InconsistencySeries all;
  double last = 0;
  for (const InconsistencySeries& s : series) {
    all.insert(all.end(), s.begin(), s.end());
    if (!s.empty()) last += static_cast<double>(s.back().combined());
  }
  Inconsistency r = summarize(all);
  if (series.empty()) return r;
  r.area_ms /= static_cast<double>(series.size());
  r.final_m = last / static_cast<double>(series.size());
  return r;
}

Inconsistency InconsistencyMeter::overall() const {
  return summarize_all(series_);
}

}  // namespace padr::trace
