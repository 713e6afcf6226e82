#include "tools/lab/alternatives/timeline.h"

namespace padr::lab::alternatives {
namespace {

constexpr std::size_t kKept = 20 * kTicksPerSecond;

std::uint64_t hash_of(const world::Snapshot& s) {
  WideHasher h;
  add_to_hash(h, s);
  return h.value();
}

}  // namespace

Timeline::Timeline(const Scene& scene, int peers, const Spec& spec)
    : quantiser_(scene, spec.steps_per_m), world_(scene, peers), delay_(spec.input_delay) {
  let_all_play(world_);
  for (PeerId p = 0; p < peers; ++p) inputs_.push_back(rest_of(world_, p, quantiser_));
  keep();
  for (Tick t = 0; t < delay_; ++t) {
    step_with_inputs(world_, inputs_, quantiser_);
    keep();
  }
}

void Timeline::keep() {
  world_.save(snapshot_);
  Moment m;
  for (EntityId e = 0; e < world_.entities(); ++e) m.places.push_back(world_.position(e));
  m.hash = hash_of(snapshot_);
  moments_.push_back(std::move(m));
  if (moments_.size() <= kKept) return;
  moments_.pop_front();
  ++first_;
}

void Timeline::step(std::span<const Vec2> hands) {
  ++now_;
  for (std::size_t p = 0; p < hands.size(); ++p) inputs_[p] = input_of(hands[p], quantiser_);
  step_with_inputs(world_, inputs_, quantiser_);
  keep();
}

bool Timeline::agrees(Tick tick, const world::Snapshot& state) const {
  return tick < first_ || moment(tick).hash == hash_of(state);
}

}  // namespace padr::lab::alternatives
