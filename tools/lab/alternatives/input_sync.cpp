#include "tools/lab/alternatives/input_sync.h"

#include <algorithm>

namespace padr::lab::alternatives {
namespace {

constexpr Tick kNone = std::numeric_limits<Tick>::max();
constexpr Tick kMostTold = 64;  // inputs in a datagram, as GGPO keeps so many that are not acknowledged

}  // namespace

InputSync::InputSync(const Scene& scene, const AlternativeConfig& config)
    : config_(config),
      quantiser_(scene, config.spec.steps_per_m),
      world_(scene, config.peers),
      mailbox_(config),
      acknowledged_(static_cast<std::size_t>(config.peers), config.spec.input_delay),
      saved_(static_cast<std::size_t>(config.spec.prediction) + 2) {
  let_all_play(world_);
  for (PeerId p = 0; p < config.peers; ++p)
    tracks_.emplace_back(rest_of(world_, p, quantiser_), config.spec.input_delay);
  world_.save(saved(0));
}

const Claim& InputSync::claim(EntityId /*body*/) const {
  static constexpr Claim kNobodys{kNoPeer, 0, false, false};
  return kNobodys;
}

Tick InputSync::complete() const {
  Tick t = kNone;
  for (const InputTrack& track : tracks_) t = std::min(t, track.newest());
  return t;
}

Alternative::Settled InputSync::settled() const {
  const Tick t = std::min(complete(), tick_);
  return {t, &saved(t)};
}

void InputSync::receive(std::span<const std::byte> datagram) {
  if (const auto letter = mailbox_.open(datagram)) {
    BitReader r(letter->payload);
    if (take(letter->from, r)) return;
  }
  mailbox_.count_dropped();
}

bool InputSync::take(PeerId from, BitReader& r) {
  InputTrack& track = tracks_[from];
  const Tick acknowledged = whole_tick(r.get(kTickBits), now_);
  const Tick first = whole_tick(r.get(kTickBits), now_);
  InputReader inputs(r, quantiser_);
  if (!r.ok() || acknowledged > tracks_[config_.self].newest() || first > track.newest() + 1) return false;
  bool useful = acknowledged > acknowledged_[from];
  acknowledged_[from] = std::max(acknowledged_[from], acknowledged);
  for (Tick t = first; inputs.left() > 0; ++t) {
    const Quantised input = inputs.next();
    // Clocks agree: nobody has inputs of a time that is still to come.
    if (!r.ok() || t > now_ + 1 + config_.spec.input_delay) return false;
    if (t <= track.newest()) continue;
    if (t <= tick_ && !(input == track.at(t))) first_wrong_ = std::min(first_wrong_, t);
    track.add(input);
    useful = true;
  }
  return useful;
}

void InputSync::roll_back() {
  if (first_wrong_ <= tick_) {
    simulated_again_ += static_cast<std::uint64_t>(tick_ - first_wrong_ + 1);
    tick_ = first_wrong_ - 1;
    world_.restore(saved(tick_));
  }
  first_wrong_ = kNone;
}

void InputSync::advance() {
  const Tick until = std::min(now_, complete() + config_.spec.prediction);
  while (tick_ < until) {
    ++tick_;
    inputs_.clear();
    for (const InputTrack& track : tracks_) inputs_.push_back(track.at(tick_));
    step_with_inputs(world_, inputs_, quantiser_);
    world_.save(saved(tick_));
  }
}

void InputSync::forget() {
  const Tick settled = std::min(complete(), tick_);
  Tick everywhere = settled;
  for (PeerId p = 0; p < config_.peers; ++p)
    if (p != config_.self) everywhere = std::min(everywhere, acknowledged_[p]);
  for (PeerId p = 0; p < config_.peers; ++p) tracks_[p].forget_before(p == config_.self ? everywhere : settled);
}

void InputSync::step(Vec2 target) {
  ++now_;
  mailbox_.begin_tick();
  tracks_[config_.self].add(input_of(target, quantiser_));
  const Tick before = tick_;
  roll_back();
  advance();
  frozen_ = tick_ == before;
  send();
  forget();
}

void InputSync::send() {
  if (now_ % (kTicksPerSecond / config_.spec.hz) != 0) return;
  for (PeerId p = 0; p < config_.peers; ++p) {
    if (p == config_.self) continue;
    const Tick first = acknowledged_[p] + 1;
    BitWriter w;
    w.put(static_cast<std::uint32_t>(tracks_[p].newest()) & 0xFFFFU, kTickBits);
    w.put(static_cast<std::uint32_t>(first) & 0xFFFFU, kTickBits);
    const std::size_t room = wire::kMaxPayload * 8 - w.bits();
    const std::uint64_t told = tracks_[config_.self].write(w, first, kMostTold, room, quantiser_);
    mailbox_.post(p, w, told);
  }
}

}  // namespace padr::lab::alternatives
