#include "tools/monitor/agreement.h"

#include <algorithm>

namespace padr::monitor {

void Agreement::note(PeerId slot, Tick tick, std::uint64_t hash) {
  if (told_.size() >= kTicks && tick < told_.begin()->first) return;
  auto& told = told_[tick];
  const auto [at, fresh] = told.emplace(slot, hash);
  if (!fresh && at->second == hash) return;
  at->second = hash;
  if (told.size() > 1) {
    ++compared_;
    newest_ = std::max(newest_, tick);
    judge(tick, told);
  }
  while (told_.size() > kTicks) told_.erase(told_.begin());
}

void Agreement::judge(Tick tick, const std::map<PeerId, std::uint64_t>& told) {
  std::map<std::uint64_t, int> votes;
  for (const auto& [slot, hash] : told) ++votes[hash];
  std::uint64_t right = told.begin()->second;
  for (const auto& [slot, hash] : told)
    if (votes[hash] > votes[right]) right = hash;
  for (const auto& [slot, hash] : told) {
    State& s = states_[slot];
    if (tick < s.tick) continue;
    s = {tick, hash != right};
  }
  if (votes.size() > 1) first_difference_ = std::min(first_difference_.value_or(tick), tick);
}

void Agreement::forget(PeerId slot) {
  states_.erase(slot);
  for (auto& [tick, told] : told_) told.erase(slot);
}

Agreement::Verdict Agreement::of(PeerId slot) const {
  const auto found = states_.find(slot);
  if (found == states_.end()) return Verdict::kUnknown;
  return found->second.differs ? Verdict::kDiffers : Verdict::kIdentical;
}

Agreement::Verdict Agreement::all() const {
  if (states_.empty()) return Verdict::kUnknown;
  const bool differs = std::any_of(states_.begin(), states_.end(), [](const auto& s) { return s.second.differs; });
  return differs ? Verdict::kDiffers : Verdict::kIdentical;
}

}  // namespace padr::monitor
