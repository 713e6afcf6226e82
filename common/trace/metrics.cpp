#include "common/trace/metrics.h"

#include <algorithm>
#include <array>
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

InconsistencyMeter::PendingTicks::iterator InconsistencyMeter::pending(Tick tick) {
  if (const auto found = pending_.find(tick); found != pending_.end()) return found;
  if (spare_.empty())
    return pending_
        .emplace(tick, Pending{std::vector<View>(slots_.size()), std::vector<char>(slots_.size(), 0), false, {}})
        .first;
  PendingTicks::node_type replica = std::move(spare_.back());
  spare_.pop_back();
  replica.key() = tick;
  return pending_.insert(std::move(replica)).position;
}

void InconsistencyMeter::view(std::size_t viewer, Tick tick, const View& v) {
  const auto at = pending(tick);
  at->second.views[viewer] = v;
  at->second.there[viewer] = 1;
  settle(at);
}

void InconsistencyMeter::gone(std::size_t viewer, Tick from) {
  gone_from_[viewer] = std::min(gone_from_[viewer], from);
  for (auto at = pending_.lower_bound(from); at != pending_.end();) settle(at++);
}

void InconsistencyMeter::truth(Tick tick, const Truth& t) {
  const auto at = pending(tick);
  at->second.has_truth = true;
  at->second.truth = t;
  settle(at);
}

bool InconsistencyMeter::ready(Tick tick, const Pending& p) const {
  if (!p.has_truth) return false;
  for (std::size_t v = 0; v < slots_.size(); ++v)
    if (tick >= came_at_[v] && tick < gone_from_[v] && p.there[v] == 0) return false;
  return true;
}

void InconsistencyMeter::settle(PendingTicks::iterator at) {
  auto& [tick, p] = *at;
  if (!ready(tick, p)) return;
  measure(tick, p);
  p.has_truth = false;
  std::fill(p.there.begin(), p.there.end(), char{0});
  spare_.push_back(pending_.extract(at));
}

namespace {

/// The views that an unowned body of a view is compared with, if that plays them out alone.
class Others {
 public:
  Others(const View& view, const std::vector<const View*>& by_slot, const Truth& truth, int bodies) {
    if (!view.unowned_alone) return;
    for (std::size_t p = 0; p < by_slot.size(); ++p) {
      const std::size_t avatar = static_cast<std::size_t>(bodies) + p;
      if (avatar >= truth.present.size() || !truth.present[avatar]) continue;
      if (by_slot[p] != nullptr && by_slot[p] != &view) views_[n_++] = by_slot[p];
    }
  }
  bool any() const { return n_ > 0; }
  float mean_distance(std::size_t e, Vec2 from) const {
    float sum = 0;
    for (std::size_t i = 0; i < n_; ++i)
      if (views_[i]->live[e] != from) sum += distance(views_[i]->live[e], from);
    return sum / static_cast<float>(n_);
  }

 private:
  std::array<const View*, kMaxPeers> views_{};
  std::size_t n_ = 0;
};

}  // namespace

InconsistencyPoint inconsistency_of(const View& view, const std::vector<const View*>& by_slot, const Truth& truth,
                                    int bodies, Tick tick) {
  float avatars_m = 0;
  float bodies_m = 0;
  float shown_m = 0;
  const Others others(view, by_slot, truth, bodies);
  for (std::size_t e = 0; e < truth.owner.size(); ++e) {
    const PeerId owner = truth.owner[e];
    const View* owners = owner == kNoPeer ? nullptr : by_slot[owner];
    if (!truth.present[e]) continue;
    if (owner == kNoPeer && others.any()) {
      bodies_m += others.mean_distance(e, view.live[e]);
      shown_m += others.mean_distance(e, view.shown[e]);
      continue;
    }
    const Vec2 there = owners != nullptr ? owners->live[e] : truth.agreed[e];
    const Vec2 live = view.live[e];
    const Vec2 shown = view.shown[e];
    // Most are where they should be, in most views.
    if (live != there) (e < static_cast<std::size_t>(bodies) ? bodies_m : avatars_m) += distance(live, there);
    if (shown != there) shown_m += distance(shown, there);
  }
  return {tick, avatars_m, bodies_m, shown_m};
}

void InconsistencyMeter::measure(Tick tick, const Pending& p) {
  by_slot_.assign(kMaxPeers, nullptr);
  for (std::size_t v = 0; v < slots_.size(); ++v)
    if (p.there[v] != 0) by_slot_[slots_[v]] = &p.views[v];
  for (std::size_t v = 0; v < slots_.size(); ++v) {
    if (p.there[v] == 0 || tick >= gone_from_[v]) continue;
    series_[v].push_back(inconsistency_of(p.views[v], by_slot_, p.truth, bodies_, tick));
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
