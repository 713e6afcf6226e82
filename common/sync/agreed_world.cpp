#include "common/sync/agreed_world.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/sync/arrival_timeline.h"
#include "common/sync/rewinding_timeline.h"

namespace padr::sync {

AgreedWorld::AgreedWorld(const Scene& scene, const AgreedConfig& config, ConfirmedSink on_confirmed)
    : config_(config),
      on_confirmed_(std::move(on_confirmed)),
      log_(config.slots),
      predicted_(scene, config.slots, config.peers, config.authority, config.wanted),
      budget_(config.replay_budget) {
  for (PeerId p = 0; p < config.peers; ++p) log_.begin(p, 0, -1);
  begin();
}

AgreedWorld::AgreedWorld(const Scene& scene, const AgreedConfig& config, const Transfer& start,
                         ConfirmedSink on_confirmed)
    : config_(config),
      on_confirmed_(std::move(on_confirmed)),
      log_(config.slots),
      predicted_(scene, config.slots, 0, config.authority),
      budget_(config.replay_budget),
      in_(false) {
  constexpr Tick kEnded = std::numeric_limits<Tick>::max();
  predicted_.restore(start.state);
  for (PeerId p = 0; p < config.slots; ++p)
    log_.begin(p, start.slots[p].first, start.state.members[p].present ? start.state.tick - 1 : kEnded);
  begin();
}

AgreedWorld::~AgreedWorld() = default;

void AgreedWorld::begin() {
  budget_.begin(now());
  SnapshotRoom(predicted_.world()).save(predicted_, confirmed_);
  if (config_.replay)
    timeline_ = std::make_unique<RewindingTimeline>(parts());
  else
    timeline_ = std::make_unique<ArrivalTimeline>(parts());
  log_.prune(now(), now());
  announce(confirmed_);
}

TimelineParts AgreedWorld::parts() {
  return {config_,
          log_,
          predicted_,
          confirmed_,
          budget_,
          replayed_steps_,
          [this] { return complete(); },
          [this](const FoldState& s) { announce(s); }};
}

void AgreedWorld::set_replay(bool on) {
  if (on == config_.replay) return;
  timeline_->finish();
  config_.replay = on;
  if (on) {
    auto rewinding = std::make_unique<RewindingTimeline>(parts());
    rewinding->replay_all();
    timeline_ = std::move(rewinding);
  } else {
    timeline_ = std::make_unique<ArrivalTimeline>(parts());
  }
  timeline_->look();
}

bool AgreedWorld::insert(const Bundle& bundle) {
  if (!log_.insert(bundle)) return false;
  timeline_->file(bundle);
  return true;
}

void AgreedWorld::close(PeerId peer, std::uint32_t count) {
  timeline_->undo(peer, count, log_.close(peer, count));
}

std::vector<Bundle> AgreedWorld::hold(PeerId peer) {
  std::vector<Bundle> held = log_.hold(peer);
  const Tick earliest = held.empty() ? std::numeric_limits<Tick>::max() : held.front().tick;
  timeline_->undo(peer, log_.have(peer), earliest);
  return held;
}

void AgreedWorld::enter(Tick since) {
  log_.open(config_.self, since);
  in_ = true;
}

void AgreedWorld::step() {
  if (budget_.begun() < now()) budget_.begin(now());  // nobody confirms
  timeline_->catch_up();
  timeline_->step();
  timeline_->look();
}

// The state at the begin of a tick rests on the updates of all ticks below it.
Tick AgreedWorld::complete() const {
  Tick t = now() - 1;
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self || !in_ || log_.waits(p)) t = std::min(t, log_.complete(p));
  return t + 1;
}

void AgreedWorld::confirm() {
  timeline_->confirm(complete());
  log_.prune(confirmed_.tick, keep_);
  budget_.begin(now());
}

void AgreedWorld::announce(const FoldState& s) {
  if (on_confirmed_) on_confirmed_(s, LazyHash(s, hasher_));
}

}  // namespace padr::sync
