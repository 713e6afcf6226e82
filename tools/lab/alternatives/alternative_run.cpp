#include "tools/lab/alternatives/alternative_run.h"

#include <algorithm>
#include <numeric>

namespace padr::lab::alternatives {
namespace {

constexpr std::size_t kPast = 10 * kTicksPerSecond;

std::vector<PeerId> all_of(int peers) {
  std::vector<PeerId> all(static_cast<std::size_t>(peers));
  std::iota(all.begin(), all.end(), PeerId{0});
  return all;
}

}  // namespace

AlternativeRun::AlternativeRun(SessionConfig config)
    : config_(std::move(config)),
      links_(config_.netem, config_.netem_seed),
      meter_(config_.peers, static_cast<int>(config_.scene.bodies.size())),
      fidelity_(config_.scene, config_.peers, all_of(config_.peers)),
      targets_(static_cast<std::size_t>(config_.peers)),
      states_(static_cast<std::size_t>(config_.peers)),
      jumps_(static_cast<std::size_t>(config_.peers)),
      stood_(static_cast<std::size_t>(config_.peers)) {
  const auto n = static_cast<std::size_t>(config_.peers);
  for (PeerId p = 0; p < n; ++p) {
    peers_.push_back(
        make_alternative(config_.scene, {.self = p, .peers = config_.peers, .session = 1, .spec = config_.spec}));
  }
  if (config_.spec.kind == Kind::kInputs)
    timeline_ = std::make_unique<Timeline>(config_.scene, config_.peers, config_.spec);
  if (config_.processor_time) processor_time_ = std::make_unique<ProcessorTime>(config_.scene, config_.peers);
  for (PeerId p = 0; p < n; ++p) targets_[p] = peers_[p]->world().position(peers_[p]->world().avatar(p));
  sample();
}

void AlternativeRun::work() {
  links_.deliver(tick_start(now_), [&](std::size_t /*from*/, std::size_t to, Micros /*when*/, const auto& datagram) {
    peers_[to]->receive(datagram);
  });
  for (PeerId p = 0; p < peers_.size(); ++p) peers_[p]->step(targets_[p]);
}

void AlternativeRun::step() {
  ++now_;
  for (PeerId p = 0; p < peers_.size(); ++p) targets_[p] = config_.inputs[p]->target(now_);
  if (processor_time_) processor_time_->begin();
  work();
  if (processor_time_) {
    processor_time_->end();
    processor_time_->step_bare(targets_);
  }
  for (PeerId p = 0; p < peers_.size(); ++p)
    for (const node::Outgoing& o : peers_[p]->outgoing()) links_.send(p, o.to, tick_start(now_), o.bytes);
  if (timeline_) timeline_->step(targets_);
  sample();
}

PeerId AlternativeRun::owner(EntityId body) const {
  const Claim* best = &peers_[0]->claim(body);
  for (const auto& p : peers_)
    if (beats(p->claim(body), *best, body)) best = &p->claim(body);
  return best->owner;
}

void AlternativeRun::sample() {
  Past past;
  const world::World& any = peers_[0]->world();
  for (EntityId e = 0; e < any.entities(); ++e)
    past.owner.push_back(any.is_avatar(e) && !timeline_ ? static_cast<PeerId>(e - any.bodies()) : owner(e));
  for (PeerId p = 0; p < peers_.size(); ++p) {
    std::vector<Vec2> places;
    for (EntityId e = 0; e < any.entities(); ++e) places.push_back(peers_[p]->world().position(e));
    meter_.view(p, now_, {places, places, false});
    if (timeline_) measure_timeline(p, places);
    past.places.push_back(std::move(places));
  }
  past.hands = targets_;
  trace::Truth truth;
  truth.owner = past.owner;
  truth.present.assign(past.owner.size(), true);
  truth.agreed.assign(past.owner.size(), {});
  if (timeline_) truth.agreed = timeline_->present();
  meter_.truth(now_, truth);
  past_.push_back(std::move(past));
  if (past_.size() > kPast) past_.pop_front();
  measure_fidelity();
  measure_waiting();
  if (!timeline_) measure_delayed();
}

void AlternativeRun::measure_timeline(PeerId p, const std::vector<Vec2>& places) {
  const std::vector<Vec2>& decided = timeline_->decided();
  for (std::size_t e = 0; e < places.size(); ++e) hands_sum_ += static_cast<double>(distance(places[e], decided[e]));
  const Alternative::Settled settled = peers_[p]->settled();
  if (!timeline_->agrees(settled.tick, *settled.state)) ++mismatches_;
}

void AlternativeRun::measure_waiting() {
  std::vector<Vec2> velocity;
  for (PeerId p = 0; p < peers_.size(); ++p) {
    const world::World& w = peers_[p]->world();
    velocity.clear();
    for (EntityId e = 0; e < w.entities(); ++e) velocity.push_back(w.velocity(e));
    jumps_[p].tick(past_.back().places[p], velocity);
    if (now_ == 0) continue;
    const Tick delay = peers_[p]->hand_delay();
    hand_delay_sum_ += static_cast<double>(delay);
    hand_delay_peak_ = std::max(hand_delay_peak_, delay);
    const bool stands = peers_[p]->frozen();
    if (stands) ++frozen_;
    if (stands && stood_[p] == 0) ++freezes_;
    stood_[p] = stands ? 1 : 0;
  }
}

Waiting AlternativeRun::waiting() const {
  Waiting w;
  if (now_ == 0) return w;
  const double ticks = static_cast<double>(now_) * static_cast<double>(peers_.size());
  w.hand_delay_s = hand_delay_sum_ / ticks / kTicksPerSecond;
  w.hand_delay_peak_s = static_cast<double>(hand_delay_peak_) / kTicksPerSecond;
  w.frozen_share = static_cast<double>(frozen_) / ticks;
  w.freezes = static_cast<double>(freezes_) / ticks * kTicksPerSecond;
  return w;
}

double AlternativeRun::hands_mean_m() const {
  if (!timeline_) return meter_.overall().mean_m;
  return hands_sum_ / (static_cast<double>(now_ + 1) * static_cast<double>(peers_.size()));
}

/// What its avatar, as it is in its own view, was driven towards last.
Vec2 AlternativeRun::driven_towards(PeerId p) const {
  const auto ago = static_cast<std::size_t>(peers_[p]->hand_delay());
  return past_[past_.size() - 1 - std::min(ago, past_.size() - 1)].hands[p];
}

void AlternativeRun::measure_fidelity() {
  std::vector<trace::PlayerView> views;
  for (PeerId p = 0; p < peers_.size(); ++p) {
    const world::World& w = peers_[p]->world();
    states_[p].clear();
    for (EntityId e = 0; e < w.entities(); ++e) states_[p].push_back(w.state(e));
    views.push_back({true, states_[p], driven_towards(p)});
  }
  fidelity_.tick(now_, views);
}

void AlternativeRun::measure_delayed() {
  const Past& here = past_.back();
  for (PeerId viewer = 0; viewer < peers_.size(); ++viewer) {
    double sum = 0;
    for (EntityId e = 0; e < here.owner.size(); ++e) {
      const PeerId now_of = here.owner[e];
      if (now_of == viewer) continue;
      const auto back = static_cast<std::size_t>(std::max(0, peers_[viewer]->delay(now_of)));
      const Past& then = past_[past_.size() - 1 - std::min(back, past_.size() - 1)];
      sum += static_cast<double>(distance(here.places[viewer][e], then.places[then.owner[e]][e]));
    }
    delayed_sum_ += sum;
    ++delayed_views_;
    for (PeerId of = 0; of < peers_.size(); ++of) {
      if (of == viewer) continue;
      delay_sum_ += static_cast<double>(peers_[viewer]->delay(of)) / kTicksPerSecond;
      ++delays_;
    }
  }
}

double AlternativeRun::delayed_mean_m() const {
  if (timeline_) return meter_.overall().mean_m;
  return delayed_sum_ / static_cast<double>(delayed_views_);
}

double AlternativeRun::delay_s() const {
  return delays_ == 0 ? 0 : delay_sum_ / static_cast<double>(delays_);
}

}  // namespace padr::lab::alternatives
