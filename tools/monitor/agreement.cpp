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
    if (hash == right)
      s = {tick, -1, Verdict::kIdentical};
    else if (s.differs_since < 0)
      s = {tick, tick, Verdict::kUnknown};
    s.tick = tick;
  }
}

bool Agreement::is_other(PeerId slot) const {
  const auto found = states_.find(slot);
  return found != states_.end() && found->second.differs_since >= 0;
}

void Agreement::settle(PeerId slot, bool apart) {
  if (!is_other(slot)) return;
  State& s = states_[slot];
  s.verdict = apart ? Verdict::kApart : Verdict::kDiffers;
  if (!apart) first_difference_ = std::min(first_difference_.value_or(s.differs_since), s.differs_since);
}

void Agreement::forget(PeerId slot) {
  states_.erase(slot);
  for (auto& [tick, told] : told_) told.erase(slot);
}

Agreement::Verdict Agreement::of(PeerId slot) const {
  const auto found = states_.find(slot);
  return found == states_.end() ? Verdict::kUnknown : found->second.verdict;
}

Agreement::Verdict Agreement::all() const {
  Verdict all = Verdict::kUnknown;
  for (const auto& [slot, s] : states_) all = std::max(all, s.verdict);
  return all;
}

}  // namespace padr::monitor
