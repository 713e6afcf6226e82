#include "common/trace/fidelity.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace padr::trace {

FidelityMeter::FidelityMeter(const Scene& scene, int slots, std::vector<PeerId> viewers)
    : bodies_(scene.bodies.size()),
      viewers_(std::move(viewers)),
      unseen_(viewers_.size()),
      doers_(bodies_, viewers_.size() + 1),
      pcc_(scene, slots, viewers_),
      before_(viewers_.size()),
      is_others_(bodies_, 0),
      watched_(static_cast<std::size_t>(slots), 0),
      present_(static_cast<std::size_t>(slots), 0),
      series_(viewers_.size()) {
  for (const PeerId p : viewers_) {
    copies_.push_back(std::make_unique<Undisturbed>(scene, slots, p));
    watched_[p] = 1;
  }
}

// Of a slot that nobody watches it is not known whether somebody is in it until its avatar is seen to move.
void FidelityMeter::see_avatars(std::span<const PlayerView> views) {
  for (std::size_t p = 0; p < present_.size(); ++p)
    if (watched_[p] != 0) present_[p] = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!views[v].there) continue;
    present_[viewers_[v]] = 1;
    for (std::size_t p = 0; p < present_.size(); ++p)
      if (watched_[p] == 0 && views[v].live[bodies_ + p].awake) present_[p] = 1;
  }
}

void FidelityMeter::step_copy(std::size_t viewer, const PlayerView& view, bool gap) {
  Undisturbed& copy = *copies_[viewer];
  if (!view.there) return copy.drop();
  for (PeerId p = 0; p < present_.size(); ++p) copy.set_avatar(p, present_[p] != 0, watched_[p] == 0);
  if (gap || !copy.running()) return copy.take(view.live);
  for (EntityId b = 0; b < bodies_; ++b) {
    const int of = doers_.of(b);
    is_others_[b] = of != Doers::kNobody && of != static_cast<int>(viewer) ? 1 : 0;
  }
  copy.step(before_[viewer], is_others_, view.target);
}

void FidelityMeter::look_for_doers(Tick now, std::span<const PlayerView> views) {
  for (std::size_t v = 0; v < copies_.size(); ++v) {
    const Undisturbed& copy = *copies_[v];
    if (!copy.running()) continue;
    for (const Contact& c : copy.contacts())
      if (c.first < bodies_ && c.second >= bodies_)
        doers_.touched(c.first, c.second == copy.avatar() ? v : unseen_, now);
    doers_.spread(copy.contacts(), now);
  }
  for (EntityId b = 0; b < bodies_; ++b) {
    const int last = doers_.last(b, now);
    if (last == Doers::kNobody || last == static_cast<int>(unseen_)) continue;
    const auto doer = static_cast<std::size_t>(last);
    if (views[doer].there && length(views[doer].live[b].velocity) > Doers::kMoving) doers_.touched(b, doer, now);
  }
  doers_.judge(now);
}

FidelityPoint FidelityMeter::measure(Tick now, std::size_t viewer, const PlayerView& view) const {
  FidelityPoint p;
  p.tick = now;
  for (EntityId b = 0; b < bodies_; ++b) {
    const int of = doers_.of(b);
    if (of == Doers::kSeveral || of == static_cast<int>(unseen_)) continue;
    const std::size_t whose = of == Doers::kNobody ? viewer : static_cast<std::size_t>(of);
    if (!copies_[whose]->running()) continue;
    const Vec2 there = copies_[whose]->position(b);
    const Vec2 here = view.live[b].position;
    if (here == there) continue;
    (of == Doers::kNobody ? p.nobody_m : whose == viewer ? p.own_m : p.others_m) += distance(here, there);
  }
  return p;
}

void FidelityMeter::tick(Tick now, std::span<const PlayerView> views) {
  if (std::none_of(views.begin(), views.end(), [](const PlayerView& v) { return v.there; })) return;
  see_avatars(views);
  for (std::size_t v = 0; v < views.size(); ++v) step_copy(v, views[v], now != last_ + 1);
  last_ = now;
  look_for_doers(now, views);
  for (EntityId b = 0; b < bodies_; ++b) {
    const int of = doers_.of(b);
    if (of != Doers::kNobody) ++somebodys_;
    if (of == Doers::kSeveral || of == static_cast<int>(unseen_)) ++severals_;
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!views[v].there) continue;
    series_[v].push_back(measure(now, v, views[v]));
    before_[v].assign(views[v].live.begin(), views[v].live.end());
  }
  // Not before all have been measured: it is one copy that a body is compared with in every view.
  for (std::size_t v = 0; v < views.size(); ++v)
    if (views[v].there && copies_[v]->is_due()) copies_[v]->take(views[v].live);
  pcc_.tick(now, views, doers_);
}

double FidelityMeter::left_out() const {
  return somebodys_ == 0 ? 0 : static_cast<double>(severals_) / static_cast<double>(somebodys_);
}

Fidelity summarize(const FidelitySeries& series) {
  Fidelity f;
  f.ticks = series.size();
  if (series.empty()) return f;
  std::vector<float> errors;
  errors.reserve(series.size());
  for (const FidelityPoint& p : series) {
    errors.push_back(p.error_m());
    f.own_mean_m += static_cast<double>(p.own_m);
    f.others_mean_m += static_cast<double>(p.others_m);
    f.nobody_mean_m += static_cast<double>(p.nobody_m);
  }
  const auto n = static_cast<double>(series.size());
  f.own_mean_m /= n;
  f.others_mean_m /= n;
  f.nobody_mean_m /= n;
  f.mean_m = f.own_mean_m + f.others_mean_m + f.nobody_mean_m;
  std::sort(errors.begin(), errors.end());
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * n));
  f.p95_m = static_cast<double>(errors[std::max<std::size_t>(rank, 1) - 1]);
  f.peak_m = static_cast<double>(errors.back());
  return f;
}

Fidelity summarize_all(const std::vector<FidelitySeries>& series) {
  FidelitySeries all;
  for (const FidelitySeries& s : series) all.insert(all.end(), s.begin(), s.end());
  return summarize(all);
}

}  // namespace padr::trace
