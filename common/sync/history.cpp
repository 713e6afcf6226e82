#include "common/sync/history.h"

#include <algorithm>
#include <cassert>

namespace padr::sync {

void History::resize(std::size_t ticks) {
  at_.assign(ticks, nullptr);
  states_.clear();
  free_.clear();
  oldest_ = 0;
}

bool History::holds(Tick t) const {
  const FoldState* s = at_[index(t)];
  return s != nullptr && s->tick == t;
}

FoldState& History::at(Tick t) {
  assert(has(t));
  return *at_[index(t)];
}

const FoldState& History::at(Tick t) const {
  assert(has(t));
  return *at_[index(t)];
}

FoldState& History::place(Tick t) {
  FoldState*& here = at_[index(t)];
  if (here != nullptr) return *here;
  // Some more at once, so that a delay a little longer than any before costs something only once.
  if (free_.empty()) make_more(std::max<std::size_t>(1, states_.size() / 8));
  here = free_.back();
  free_.pop_back();
  return *here;
}

void History::reserve(std::size_t states) {
  if (states > states_.size()) make_more(states - states_.size());
}

void History::make_more(std::size_t more) {
  const std::size_t all = std::min(states_.size() + more, at_.size());
  states_.reserve(all);
  free_.reserve(all);
  while (states_.size() < all) {
    states_.push_back(states_.empty() ? std::make_unique<FoldState>() : std::make_unique<FoldState>(*states_.front()));
    FoldState& s = *states_.back();
    s.world.contacts.reserve(states_.front()->world.contacts.capacity());
    free_.push_back(&s);
  }
}

void History::forget_before(Tick t) {
  if (at_.empty()) return;
  oldest_ = std::max(oldest_, t - static_cast<Tick>(at_.size()));
  for (; oldest_ < t; ++oldest_) {
    FoldState*& there = at_[index(oldest_)];
    if (there == nullptr || there->tick >= t) continue;
    free_.push_back(there);
    there = nullptr;
  }
}

}  // namespace padr::sync
