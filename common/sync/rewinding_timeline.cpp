#include "common/sync/rewinding_timeline.h"

#include <algorithm>
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

RewindingTimeline::RewindingTimeline(const TimelineParts& parts)
    : parts_(parts),
      room_(parts.predicted.world()),
      local_(parts.predicted.world().scene(), parts.config.slots, parts.config.authority),
      dirty_(kClean) {
  room_.save(parts_.predicted, current_);
  history_.resize(parts_.config.kept_ticks);
  FoldState& first = history_.place(parts_.confirmed.tick);
  room_.make(first.world);
  first = parts_.confirmed;
  history_.reserve(parts_.config.kept_ticks / kUsualPart);
}

void RewindingTimeline::file(const Bundle& bundle) {
  if (comes_next(bundle)) {
    parts_.predicted.apply(bundle);
    told_now_ = true;
  } else if (note_late(bundle.tick)) {
    local_.concerns(bundle);
  }
}

// Of this tick, and after all that has been applied of it: nothing has to be done again. While a replay is behind,
// predicted will be put right anyway.
bool RewindingTimeline::comes_next(const Bundle& bundle) const {
  return bundle.tick == now() && (behind_ || (dirty_ == kClean && parts_.log.at(now()).back().peer == bundle.peer));
}

// What is replaying comes to the rest by itself.
bool RewindingTimeline::note_late(Tick t) {
  if (t > now() || (behind_ && t >= follower_->tick())) return false;
  dirty_ = std::min(dirty_, t);
  return true;
}

void RewindingTimeline::undo(PeerId /*peer*/, std::uint32_t /*from*/, Tick earliest) {
  if (note_late(earliest)) local_.concerns_all();
}

const FoldState* RewindingTimeline::confirmed_at(Tick t) const {
  return t <= parts_.confirmed.tick && history_.has(t) ? &history_.at(t) : nullptr;
}

void RewindingTimeline::apply_known(Fold& fold) const {
  const Tick t = fold.tick();
  if (t == parts_.config.fault.tick) fold.disturb(parts_.config.fault.entity, parts_.config.fault.by);
  for (const Bundle& b : parts_.log.at(t)) fold.apply(b);
}

void RewindingTimeline::advance_predicted() {
  parts_.predicted.step();
  room_.save(parts_.predicted, history_.place(now()));
  apply_known(parts_.predicted);
}

void RewindingTimeline::rewind_to(Tick t) {
  const Tick target = now();
  parts_.predicted.restore(history_.has(t) ? history_.at(t) : parts_.confirmed);
  if (!history_.has(now())) room_.save(parts_.predicted, history_.place(now()));
  apply_known(parts_.predicted);
  while (now() < target) {
    advance_predicted();
    parts_.budget.spend_step(parts_.predicted);
    ++parts_.replayed_steps;
  }
}

Fold& RewindingTimeline::follower() {
  if (!follower_)
    follower_ =
        std::make_unique<Fold>(parts_.predicted.world().scene(), parts_.config.slots, 0, parts_.config.authority);
  return *follower_;
}

void RewindingTimeline::fall_behind() {
  follower().restore(history_.has(dirty_) ? history_.at(dirty_) : parts_.confirmed);
  settle();
  behind_ = true;
  follows_confirmed_ = false;
  look();  // a local replay that gave up has left its traces in the history
}

void RewindingTimeline::step_behind() {
  Fold& f = *follower_;
  apply_known(f);
  f.step();
  parts_.budget.spend_step(f);
  ++parts_.replayed_steps;
  const bool kept = now() - f.tick() < static_cast<Tick>(parts_.config.kept_ticks);
  if (kept) f.save(history_.place(f.tick()));
  // Older than what is kept: who confirms it has to do so now.
  if (f.tick() != parts_.confirmed.tick + 1 || f.tick() > std::min(parts_.complete(), dirty_)) return;
  if (kept)
    parts_.confirmed = history_.at(f.tick());
  else
    f.save(parts_.confirmed);
  parts_.announce(parts_.confirmed);
}

// True once it has caught up.
bool RewindingTimeline::catch_up_behind() {
  while (follower_->tick() < now()) {
    if (!parts_.budget.may_step()) return false;
    step_behind();
  }
  behind_ = false;
  parts_.predicted.restore(history_.at(now()));
  apply_known(parts_.predicted);
  return true;
}

bool RewindingTimeline::is_too_long() const {
  const Tick steps = now() - (history_.has(dirty_) ? dirty_ : parts_.confirmed.tick);
  return !parts_.budget.bears(steps, parts_.predicted);
}

bool RewindingTimeline::replay() {
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

void RewindingTimeline::settle() {
  local_.clear();
  dirty_ = kClean;
}

// The fault lies in the ticks of the fold itself, so everything has to be folded for it.
bool RewindingTimeline::replay_locally() {
  if (parts_.config.fault.tick >= dirty_) return false;
  const bool done = local_.run(history_, parts_.log, dirty_, now(), parts_.budget.left());
  parts_.budget.leave(local_.left());
  if (!done) return false;
  if (parts_.log.at(now()).empty()) {
    parts_.predicted.restore_only(history_.at(now()), local_.changed(), local_.unchanged());
  } else {
    parts_.predicted.restore(history_.at(now()));
    apply_known(parts_.predicted);
  }
  return true;
}

// Where this tick has no updates the history has it already.
void RewindingTimeline::look() {
  in_history_ = !behind_ && parts_.log.at(now()).empty();
  if (!in_history_) room_.save(parts_.predicted, current_);
}

Tick RewindingTimeline::replayed_to() const {
  return behind_ ? std::min(dirty_, follower_->tick()) : dirty_;
}

void RewindingTimeline::confirm_from_kept(Tick upto) {
  follows_confirmed_ = false;
  for (Tick t = parts_.confirmed.tick + 1; t <= upto; ++t) parts_.announce(history_.at(t));
  room_.make(parts_.confirmed.world);
  parts_.confirmed = history_.at(upto);
}

// Confirmed lags by more than is kept, so its ticks are folded once more.
void RewindingTimeline::confirm_by_folding(Tick upto) {
  Fold& fold = follower();
  if (!follows_confirmed_) fold.restore(parts_.confirmed);
  follows_confirmed_ = true;
  while (fold.tick() < upto && !history_.has(fold.tick() + 1) && parts_.budget.may_step()) {
    apply_known(fold);
    fold.step();
    parts_.budget.spend_step(fold);
    fold.save(parts_.confirmed);
    parts_.announce(parts_.confirmed);
  }
}

bool RewindingTimeline::catch_up() {
  if (dirty_ == kClean && !behind_ && !told_now_) return false;
  const bool told = std::exchange(told_now_, false);
  if (!replay() && !told) return false;
  look();
  return true;
}

void RewindingTimeline::finish() {
  do {
    parts_.budget.lift();
    catch_up();
  } while (behind_ || dirty_ != kClean);
}

void RewindingTimeline::confirm(Tick complete) {
  const Tick upto = std::min(complete, replayed_to());
  const Tick next = parts_.confirmed.tick + 1;
  if (next <= upto && !history_.has(next) && !behind_) confirm_by_folding(upto);
  if (parts_.confirmed.tick < upto && history_.has(parts_.confirmed.tick + 1)) confirm_from_kept(upto);
  history_.forget_before(parts_.confirmed.tick - kKeptConfirmed);
}

}  // namespace padr::sync
