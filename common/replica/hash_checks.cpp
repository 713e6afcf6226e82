#include "common/replica/hash_checks.h"

#include <algorithm>

namespace padr::node {

void HashChecks::add_own(Tick tick, std::uint32_t hash) {
  if (own_.size() == kKept) own_.erase(own_.begin());
  own_.push_back({tick, hash});
}

const HashChecks::Own* HashChecks::own(Tick tick) const {
  const auto found = std::lower_bound(own_.begin(), own_.end(), tick, [](const Own& o, Tick t) { return o.tick < t; });
  return found == own_.end() || found->tick != tick ? nullptr : &*found;
}

void HashChecks::put_off(const Told& told) {
  std::size_t others = 0;
  for (const Told& t : waiting_) {
    if (t.from != told.from) continue;
    if (t.tick == told.tick || ++others == kKept) return;
  }
  const auto place = std::lower_bound(waiting_.begin(), waiting_.end(), told.tick,
                                      [](const Told& t, Tick tick) { return t.tick > tick; });
  waiting_.insert(place, told);
}

bool HashChecks::take(Tick confirmed, Told& out) {
  if (waiting_.empty() || waiting_.back().tick > confirmed) return false;
  out = waiting_.back();
  waiting_.pop_back();
  return true;
}

}  // namespace padr::node
