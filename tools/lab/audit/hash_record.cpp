#include "tools/lab/audit/hash_record.h"

#include <algorithm>

namespace padr::lab::audit {
namespace {

// As Replica exchanges them: of every so many ticks, 32 bits, never 0.
constexpr Tick kCheckEvery = 30;

}  // namespace

void HashRecord::confirmed(Tick tick, std::uint64_t hash) {
  if (tick % kCheckEvery == 0) own_[tick] = static_cast<std::uint32_t>(hash) | 1U;
}

void HashRecord::told(Sitter who, Tick at, Tick tick, std::uint32_t hash) {
  if (tick < 0 || tick % kCheckEvery != 0) return;
  std::vector<Told>& all = told_[who];
  const auto place =
      std::lower_bound(all.begin(), all.end(), tick, [](const Told& t, Tick wanted) { return t.tick < wanted; });
  if (place != all.end() && place->tick == tick)
    place->at = std::min(place->at, at);
  else
    all.insert(place, {at, tick, hash});
}

Tick HashRecord::confirmed_by(Sitter who, Tick at) const {
  const auto all = told_.find(who);
  Tick newest = -1;
  if (all != told_.end())
    for (auto t = all->second.rbegin(); t != all->second.rend() && newest < 0; ++t)
      if (t->at <= at) newest = t->tick;
  return newest;
}

HashRecord::Verdict HashRecord::compare(const Told& told) const {
  const auto own = own_.find(told.tick);
  if (own == own_.end()) return Verdict::kUnknown;
  return own->second == told.hash ? Verdict::kSame : Verdict::kDiffers;
}

HashRecord::Verdict HashRecord::before(Sitter who, Tick tick) const {
  const auto all = told_.find(who);
  if (all == told_.end()) return Verdict::kUnknown;
  for (auto t = all->second.rbegin(); t != all->second.rend(); ++t)
    if (t->tick <= tick && compare(*t) != Verdict::kUnknown) return compare(*t);
  return Verdict::kUnknown;
}

HashRecord::Verdict HashRecord::after(Sitter who, Tick tick) const {
  const auto all = told_.find(who);
  if (all == told_.end()) return Verdict::kUnknown;
  for (const Told& t : all->second)
    if (t.tick > tick && compare(t) != Verdict::kUnknown) return compare(t);
  return Verdict::kUnknown;
}

}  // namespace padr::lab::audit
