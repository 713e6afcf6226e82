#include "common/sync/agreed_world.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

namespace padr::sync {
namespace {

constexpr Tick kClean = std::numeric_limits<Tick>::max();
// Confirmed states are kept this long for whoever wants to compare with what somebody else sends.
constexpr Tick kKeptConfirmed = kTicksPerSecond / 2;
// Of the states that may be kept there is memory for this part from the start, of a session for 2.1 s.
constexpr std::size_t kUsualPart = 4;

}  // namespace

AgreedWorld::AgreedWorld(const Scene& scene, const AgreedConfig& config, ConfirmedSink on_confirmed)
    : config_(config),
      on_confirmed_(std::move(on_confirmed)),
      log_(config.slots),
      predicted_(scene, config.slots, config.peers, config.authority),
      dirty_(kClean),
      budget_(config.replay_budget) {
  if (!config.replay) follower_ = std::make_unique<Fold>(scene, config.slots, config.peers, config.authority);
  for (PeerId p = 0; p < config.peers; ++p) log_.begin(p, 0, -1);
  begin();
}

AgreedWorld::AgreedWorld(const Scene& scene, const AgreedConfig& config, const Transfer& start,
                         ConfirmedSink on_confirmed)
    : config_(config),
      on_confirmed_(std::move(on_confirmed)),
      log_(config.slots),
      predicted_(scene, config.slots, 0, config.authority),
      dirty_(kClean),
      budget_(config.replay_budget),
      in_(false) {
  predicted_.restore(start.state);
  if (!config.replay) {
    follower_ = std::make_unique<Fold>(scene, config.slots, 0, config.authority);
    follower_->restore(start.state);
  }
  for (PeerId p = 0; p < config.slots; ++p)
    log_.begin(p, start.slots[p].first, start.state.members[p].present ? start.state.tick - 1 : kClean);
  begin();
}

void AgreedWorld::begin() {
  budget_.begin(now());
  follows_confirmed_ = !config_.replay;
  most_contacts_ = predicted_.world().usual_contacts();
  save_predicted(current_);
  confirmed_ = current_;
  if (config_.replay) {
    begin_history();
  } else {
    expect_arrivals();
  }
  log_.prune(now(), now());
  announce(confirmed_);
}

// With what is confirmed.
void AgreedWorld::begin_history() {
  history_.resize(config_.kept_ticks);
  FoldState& first = history_.place(confirmed_.tick);
  make_room(first.world);
  first = confirmed_;
  history_.reserve(config_.kept_ticks / kUsualPart);
  local_ = std::make_unique<LocalReplay>(predicted_.world().scene(), config_.slots, config_.authority);
}

void AgreedWorld::expect_arrivals() {
  arrivals_.emplace(config_.slots, predicted_.world().bodies());
}

void AgreedWorld::set_replay(bool on) {
  if (on == config_.replay) return;
  do {
    budget_.lift();
    catch_up();
  } while (behind_ || dirty_ != kClean);
  config_.replay = on;
  if (on)
    begin_replay();
  else
    end_replay();
  look();
}

void AgreedWorld::begin_replay() {
  arrivals_.reset();
  follows_confirmed_ = false;
  begin_history();
  rewind_to(confirmed_.tick);
}

// Predicted goes on as it is. Updates that are in it count as having arrived, those of ticks to come arrive now.
void AgreedWorld::end_replay() {
  history_.resize(0);
  local_.reset();
  follower().restore(confirmed_);
  follows_confirmed_ = true;
  expect_arrivals();
  for (const Bundle& b : log_.since(confirmed_.tick)) {
    if (b.tick > now()) {
      arrivals_->add(b);
    } else {
      arrivals_->note(b);
    }
  }
}

bool AgreedWorld::insert(const Bundle& bundle) {
  if (!log_.insert(bundle)) return false;
  if (!config_.replay) {
    arrivals_->add(bundle);
  } else if (comes_next(bundle)) {
    predicted_.apply(bundle);
    told_now_ = true;
  } else if (note_late(bundle.tick)) {
    local_->concerns(bundle);
  }
  return true;
}

// Of this tick, and after all that has been applied of it: nothing has to be done again. While a replay is behind,
// predicted will be put right anyway.
bool AgreedWorld::comes_next(const Bundle& bundle) const {
  return bundle.tick == now() && (behind_ || (dirty_ == kClean && log_.at(now()).back().peer == bundle.peer));
}

// What is replaying comes to the rest by itself.
bool AgreedWorld::note_late(Tick t) {
  if (t > now() || (behind_ && t >= follower_->tick())) return false;
  dirty_ = std::min(dirty_, t);
  return true;
}

void AgreedWorld::close(PeerId peer, std::uint32_t count) {
  undo(peer, count, log_.close(peer, count));
}

std::vector<Bundle> AgreedWorld::hold(PeerId peer) {
  std::vector<Bundle> held = log_.hold(peer);
  undo(peer, log_.have(peer), held.empty() ? kClean : held.front().tick);
  return held;
}

void AgreedWorld::undo(PeerId peer, std::uint32_t from, Tick earliest) {
  if (config_.replay && note_late(earliest)) local_->concerns_all();
  if (arrivals_) arrivals_->take_back(peer, from);
}

void AgreedWorld::enter(Tick since) {
  log_.open(config_.self, since);
  in_ = true;
}

const FoldState* AgreedWorld::confirmed_at(Tick t) const {
  return t <= confirmed_.tick && history_.has(t) ? &history_.at(t) : nullptr;
}

void AgreedWorld::apply_known(Fold& fold) const {
  const Tick t = fold.tick();
  if (config_.replay && t == config_.fault.tick) fold.disturb(config_.fault.entity, config_.fault.by);
  for (const Bundle& b : log_.at(t)) fold.apply(b);
}

// As many contacts as there once were may be there again: every place that is kept has room for them at once, not when
// its turn comes.
void AgreedWorld::make_room(world::Snapshot& s) const {
  s.contacts.reserve(most_contacts_);
  s.parted.reserve(most_parted_);
}

void AgreedWorld::save_predicted(FoldState& out) {
  make_room(out.world);
  predicted_.save(out);
  most_contacts_ = std::max(most_contacts_, std::bit_ceil(out.world.contacts.size()));
  most_parted_ = std::max(most_parted_, std::bit_ceil(out.world.parted.size()));
}

void AgreedWorld::advance_predicted() {
  predicted_.step();
  if (!config_.replay) return;
  save_predicted(history_.place(now()));
  apply_known(predicted_);
}

void AgreedWorld::rewind_to(Tick t) {
  const Tick target = now();
  predicted_.restore(history_.has(t) ? history_.at(t) : confirmed_);
  if (!history_.has(now())) save_predicted(history_.place(now()));
  apply_known(predicted_);
  while (now() < target) {
    advance_predicted();
    budget_.spend_step(predicted_);
    ++replayed_steps_;
  }
}

Fold& AgreedWorld::follower() {
  if (!follower_) follower_ = std::make_unique<Fold>(predicted_.world().scene(), config_.slots, 0, config_.authority);
  return *follower_;
}

void AgreedWorld::fall_behind() {
  follower().restore(history_.has(dirty_) ? history_.at(dirty_) : confirmed_);
  settle();
  behind_ = true;
  follows_confirmed_ = false;
  look();  // a local replay that gave up has left its traces in the history
}

void AgreedWorld::step_behind() {
  Fold& f = *follower_;
  apply_known(f);
  f.step();
  budget_.spend_step(f);
  ++replayed_steps_;
  const bool kept = now() - f.tick() < static_cast<Tick>(config_.kept_ticks);
  if (kept) f.save(history_.place(f.tick()));
  // Older than what is kept: who confirms it has to do so now.
  if (f.tick() != confirmed_.tick + 1 || f.tick() > std::min(confirmable(), dirty_)) return;
  if (kept)
    confirmed_ = history_.at(f.tick());
  else
    f.save(confirmed_);
  announce(confirmed_);
}

// True once it has caught up.
bool AgreedWorld::catch_up_behind() {
  while (follower_->tick() < now()) {
    if (!budget_.may_step()) return false;
    step_behind();
  }
  behind_ = false;
  predicted_.restore(history_.at(now()));
  apply_known(predicted_);
  return true;
}

bool AgreedWorld::is_too_long() const {
  const Tick steps = now() - (history_.has(dirty_) ? dirty_ : confirmed_.tick);
  return !budget_.bears(steps, predicted_);
}

bool AgreedWorld::replay() {
  bool changed = false;
  while (behind_ || dirty_ != kClean) {
    if (behind_) {
      if (!catch_up_behind()) break;
    } else if (replay_locally()) {
      settle();
    } else if (is_too_long()) {
      fall_behind();
      continue;
    } else {
      rewind_to(dirty_);
      settle();
    }
    changed = true;
  }
  return changed;
}

void AgreedWorld::settle() {
  local_->clear();
  dirty_ = kClean;
}

// The fault lies in the ticks of the fold itself, so everything has to be folded for it.
bool AgreedWorld::replay_locally() {
  if (config_.fault.tick >= dirty_) return false;
  const bool done = local_->run(history_, log_, dirty_, now(), budget_.left());
  budget_.leave(local_->left());
  if (!done) return false;
  if (log_.at(now()).empty()) {
    predicted_.restore_only(history_.at(now()), local_->changed(), local_->unchanged());
  } else {
    predicted_.restore(history_.at(now()));
    apply_known(predicted_);
  }
  return true;
}

bool AgreedWorld::catch_up() {
  if (config_.replay) {
    if (dirty_ == kClean && !behind_ && !told_now_) return false;
    const bool told = std::exchange(told_now_, false);
    if (!replay() && !told) return false;
  } else {
    if (!arrivals_->any()) return false;
    arrivals_->apply_to(predicted_, config_.time_stamps);
  }
  look();
  return true;
}

void AgreedWorld::step() {
  if (budget_.begun() < now()) budget_.begin(now());  // nobody confirms
  catch_up();
  advance_predicted();
  look();
}

// Where this tick has no updates the history has it already.
void AgreedWorld::look() {
  in_history_ = config_.replay && !behind_ && log_.at(now()).empty();
  if (!in_history_) save_predicted(current_);
}

Tick AgreedWorld::complete_tick() const {
  Tick t = now();
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self || !in_ || log_.waits(p)) t = std::min(t, log_.complete(p));
  return t;
}

// The state at the begin of tick t rests on the updates of all ticks below t.
Tick AgreedWorld::confirmable() const {
  return std::min(complete_tick(), now() - 1) + 1;
}

Tick AgreedWorld::replayed_to() const {
  return behind_ ? std::min(dirty_, follower_->tick()) : dirty_;
}

void AgreedWorld::confirm() {
  const Tick upto = std::min(confirmable(), replayed_to());
  if (confirmed_.tick < upto && !history_.has(confirmed_.tick + 1) && !behind_) confirm_by_folding(upto);
  if (confirmed_.tick < upto && history_.has(confirmed_.tick + 1)) confirm_from_kept(upto);
  log_.prune(confirmed_.tick, keep_);
  history_.forget_before(confirmed_.tick - kKeptConfirmed);
  budget_.begin(now());
}

void AgreedWorld::confirm_from_kept(Tick upto) {
  follows_confirmed_ = false;
  for (Tick t = confirmed_.tick + 1; t <= upto; ++t) announce(history_.at(t));
  make_room(confirmed_.world);
  confirmed_ = history_.at(upto);
}

// Without replay. With it: confirmed lags by more than is kept, so its ticks are folded once more.
void AgreedWorld::confirm_by_folding(Tick upto) {
  Fold& fold = follower();
  if (!follows_confirmed_) fold.restore(confirmed_);
  follows_confirmed_ = true;
  while (fold.tick() < upto && !history_.has(fold.tick() + 1) && budget_.may_step()) {
    apply_known(fold);
    fold.step();
    budget_.spend_step(fold);
    fold.save(confirmed_);
    announce(confirmed_);
  }
}

void AgreedWorld::announce(const FoldState& s) {
  if (on_confirmed_) on_confirmed_(s, LazyHash(s, hasher_));
}

}  // namespace padr::sync
