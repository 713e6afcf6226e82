#include "common/trace/physics_consistency_cost.h"

#include <algorithm>
#include <utility>

#include "common/trace/metrics.h"
#include "common/world/bounding_radius.h"

namespace padr::trace {
namespace {

// So far may a body have been moved in a tick by what has hit it.
constexpr float kAway = 0.1F;  // m

}  // namespace

PccMeter::PccMeter(const Scene& scene, int slots, std::vector<PeerId> viewers)
    : bodies_(scene.bodies.size()),
      viewers_(std::move(viewers)),
      reach_(world::reaches(scene, slots)),
      disturber_(bodies_, Doers::kNobody),
      off_(bodies_, 0),
      sums_(viewers_.size()),
      series_(viewers_.size()) {}

bool PccMeter::is_off(EntityId body, std::span<const PlayerView> views) const {
  const PlayerView* first = nullptr;
  for (const PlayerView& v : views) {
    if (!v.there) continue;
    if (first == nullptr) first = &v;
    const Vec2 a = first->live[body].position;
    const Vec2 b = v.live[body].position;
    if (a != b && distance(a, b) > static_cast<float>(kNoiseMetres)) return true;
  }
  return false;
}

int PccMeter::seen_at(EntityId body, std::span<const PlayerView> views) const {
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!views[v].there) continue;
    const auto is_at = [&](EntityId e) {
      const std::span<const BodyState> live = views[v].live;
      return world::within_reach(live[body].position, reach_[body] + kAway, live[e].position, reach_[e]);
    };
    for (std::size_t a = 0; a < views.size(); ++a)
      if (a != v && views[a].there && is_at(static_cast<EntityId>(bodies_ + viewers_[a]))) return static_cast<int>(a);
    for (const EntityId b : list_)
      if (b != body && disturber_[b] != Doers::kNobody && is_at(b)) return disturber_[b];
  }
  return Doers::kNobody;
}

void PccMeter::attribute(std::span<const PlayerView> views, const Doers& doers) {
  for (const EntityId b : list_) {
    const int of = doers.of(b);
    if (of >= 0 && of < static_cast<int>(viewers_.size())) {
      disturber_[b] = of;
    } else if (of == Doers::kNobody && (off_[b] == 0 || disturber_[b] == Doers::kNobody)) {
      disturber_[b] = seen_at(b, views);
    }
  }
}

void PccMeter::add(EntityId body, std::span<const PlayerView> views) {
  if (disturber_[body] == Doers::kNobody) return;
  const auto whose = static_cast<std::size_t>(disturber_[body]);
  if (!views[whose].there) return;
  const Vec2 there = views[whose].live[body].position;
  float sum = 0;
  float most = 0;
  int others = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (v == whose || !views[v].there) continue;
    const float d = distance(views[v].live[body].position, there);
    sum += d;
    most = std::max(most, d);
    ++others;
  }
  if (others == 0) return;
  sums_[whose].cost_m += sum / static_cast<float>(others);
  if (most > kOff) ++sums_[whose].bodies;
}

void PccMeter::tick(Tick now, std::span<const PlayerView> views, const Doers& doers) {
  list_.clear();
  for (EntityId b = 0; b < bodies_; ++b) {
    if (is_off(b, views)) {
      list_.push_back(b);
    } else {
      off_[b] = 0;
      disturber_[b] = Doers::kNobody;
    }
  }
  attribute(views, doers);
  sums_.assign(viewers_.size(), {now, 0, 0});
  for (const EntityId b : list_) {
    off_[b] = 1;
    add(b, views);
  }
  for (std::size_t v = 0; v < views.size(); ++v)
    if (views[v].there) series_[v].push_back(sums_[v]);
}

Pcc summarize(const PccSeries& series) {
  Pcc r;
  r.ticks = series.size();
  if (series.empty()) return r;
  for (const PccPoint& p : series) {
    r.mean_m += static_cast<double>(p.cost_m);
    r.peak_m = std::max(r.peak_m, static_cast<double>(p.cost_m));
    r.bodies_mean += p.bodies;
    r.bodies_peak = std::max(r.bodies_peak, int{p.bodies});
  }
  r.mean_m /= static_cast<double>(series.size());
  r.bodies_mean /= static_cast<double>(series.size());
  return r;
}

}  // namespace padr::trace
