#include "tools/monitor/gauge.h"

#include <algorithm>

namespace padr::monitor {
namespace {

std::vector<Vec2> positions(const std::vector<Place>& places) {
  std::vector<Vec2> out;
  out.reserve(places.size());
  for (const Place& p : places) out.push_back(p.position);
  return out;
}

}  // namespace

Gauge::Pending* Gauge::at(Tick tick) {
  if (tick <= done_) return nullptr;
  Pending& p = pending_[tick];
  while (pending_.size() > kTicks) {
    done_ = pending_.begin()->first;
    pending_.erase(pending_.begin());
  }
  return tick > done_ ? &p : nullptr;
}

void Gauge::frame(PeerId slot, std::shared_ptr<const Frame> frame) {
  const auto [span, fresh] = spans_.emplace(slot, Span{frame->tick, frame->tick});
  span->second.first = std::min(span->second.first, frame->tick);
  span->second.newest = std::max(span->second.newest, frame->tick);
  if (Pending* p = at(frame->tick)) p->frames[slot] = std::move(frame);
}

void Gauge::agreed(std::shared_ptr<const Agreed> agreed) {
  newest_agreed_ = std::max(newest_agreed_, agreed->tick);
  if (Pending* p = at(agreed->tick); p != nullptr && !p->agreed) p->agreed = std::move(agreed);
}

void Gauge::forget(PeerId slot) {
  spans_.erase(slot);
}

Gauge::State Gauge::state(Tick tick, const Pending& p) const {
  if (!p.agreed) return tick < newest_agreed_ - kPassed ? State::kLost : State::kWaits;
  for (const auto& [slot, span] : spans_) {
    const std::size_t avatar = static_cast<std::size_t>(bodies_) + slot;
    const bool in = avatar < p.agreed->flags.size() && p.agreed->flags[avatar].present;
    if (!in || tick < span.first || p.frames.contains(slot)) continue;
    return span.newest > tick + kPatience ? State::kLost : State::kWaits;
  }
  return State::kReady;
}

std::vector<Gauge::Measured> Gauge::take() {
  std::vector<Measured> out;
  for (auto it = pending_.begin(); it != pending_.end();) {
    const State s = state(it->first, it->second);
    if (s == State::kReady) measure(it->first, it->second, out);
    it = s == State::kWaits ? std::next(it) : pending_.erase(it);
  }
  return out;
}

void Gauge::measure(Tick tick, const Pending& p, std::vector<Measured>& out) const {
  const std::size_t entities = p.agreed->flags.size();
  trace::Truth truth;
  truth.agreed = positions(p.agreed->at);
  for (const EntityFlags& f : p.agreed->flags) {
    truth.owner.push_back(f.owner);
    truth.present.push_back(f.present);
  }
  std::map<PeerId, trace::View> views;
  for (const auto& [slot, frame] : p.frames)
    if (frame->live.size() == entities)
      views[slot] = {positions(frame->live), positions(frame->shown.size() == entities ? frame->shown : frame->live),
                     frame->unowned_alone};
  std::vector<const trace::View*> by_slot(kMaxPeers, nullptr);
  for (const auto& [slot, view] : views)
    if (slot < by_slot.size()) by_slot[slot] = &view;
  for (const auto& [slot, view] : views) {
    const std::size_t avatar = static_cast<std::size_t>(bodies_) + slot;
    if (avatar < entities && truth.present[avatar])
      out.emplace_back(slot, trace::inconsistency_of(view, by_slot, truth, bodies_, tick));
  }
}

}  // namespace padr::monitor
