#include "common/trace/doers.h"

#include <algorithm>

namespace padr::trace {

Doers::Doers(std::size_t bodies, std::size_t doers)
    : doers_(doers), stamps_(bodies * doers, kNever), newest_(bodies, kNever), of_(bodies, kNobody) {}

void Doers::note(EntityId body, std::size_t doer, Tick when) {
  stamp(body, doer) = std::max(stamp(body, doer), when);
  newest_[body] = std::max(newest_[body], when);
}

bool Doers::join(EntityId a, EntityId b, Tick now) {
  if (std::max(newest_[a], newest_[b]) <= now - kTogether) return false;
  bool changed = false;
  for (std::size_t d = 0; d < doers_; ++d) {
    const Tick when = std::max(stamp(a, d), stamp(b, d));
    if (when <= now - kTogether || stamp(a, d) == stamp(b, d)) continue;
    note(a, d, when);
    note(b, d, when);
    changed = true;
  }
  return changed;
}

// The time goes with it: two bodies that lie against one another do not keep one another anybody's for ever.
void Doers::spread(const std::vector<Contact>& contacts, Tick now) {
  for (bool changed = true; changed;) {
    changed = false;
    for (const Contact& c : contacts)
      if (c.second < newest_.size()) changed = join(c.first, c.second, now) || changed;
  }
}

int Doers::last(EntityId body, Tick now) const {
  if (newest_[body] <= now - kAfter) return kNobody;
  for (std::size_t d = 0; d < doers_; ++d)
    if (stamp(body, d) == newest_[body]) return static_cast<int>(d);
  return kNobody;
}

void Doers::judge(Tick now) {
  for (EntityId b = 0; b < of_.size(); ++b) {
    of_[b] = last(b, now);
    if (of_[b] == kNobody || newest_[b] <= now - kTogether) continue;
    std::size_t together = 0;
    for (std::size_t d = 0; d < doers_; ++d)
      if (stamp(b, d) > now - kTogether) ++together;
    if (together > 1) of_[b] = kSeveral;
  }
}

}  // namespace padr::trace
