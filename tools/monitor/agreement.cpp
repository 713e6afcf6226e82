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
    if (hash != right && s.verdict != Verdict::kApart) s.open = s.open < 0 ? tick : std::min(s.open, tick);
    if (tick < s.tick) continue;
    s.tick = tick;
    s.other = hash != right;
    if (!s.other) {
      if (s.verdict == Verdict::kApart) s.open = -1;  // they have met again
      s.verdict = Verdict::kIdentical;
    } else if (s.verdict == Verdict::kIdentical) {
      s.verdict = Verdict::kUnknown;
    }
  }
}

bool Agreement::is_open(PeerId slot) const {
  const auto found = states_.find(slot);
  return found != states_.end() && (found->second.other || found->second.open >= 0);
}

void Agreement::settle(PeerId slot, bool apart) {
  if (!is_open(slot)) return;
  State& s = states_[slot];
  if (s.other) s.verdict = apart ? Verdict::kApart : Verdict::kDiffers;
  if (apart || s.open < 0) return;
  first_difference_ = std::min(first_difference_.value_or(s.open), s.open);
  s.open = -1;
}

void Agreement::forget(PeerId slot) {
  const Verdict before = all();
  states_.erase(slot);
  if (states_.empty()) last_ = before;
  for (auto& [tick, told] : told_) told.erase(slot);
}

Agreement::Verdict Agreement::of(PeerId slot) const {
  const auto found = states_.find(slot);
  return found == states_.end() ? Verdict::kUnknown : found->second.verdict;
}

Agreement::Verdict Agreement::all() const {
  if (states_.empty()) return last_;
  Verdict all = Verdict::kUnknown;
  for (const auto& [slot, s] : states_) all = std::max(all, s.verdict);
  return all;
}

}  // namespace padr::monitor
