#include "tools/report/confirmed_ticks.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

namespace padr::report {

/// "peers 0 2 against peer 1"
std::string ConfirmedTicks::sides(const std::vector<Entry>& entries) const {
  std::map<std::uint64_t, std::vector<std::size_t>> by_hash;
  for (const Entry& e : entries) by_hash[e.hash].push_back(e.life);
  std::vector<std::vector<std::size_t>> sides;
  for (auto& [hash, lives] : by_hash) {
    std::sort(lives.begin(), lives.end());
    sides.push_back(std::move(lives));
  }
  std::sort(sides.begin(), sides.end());
  std::string text;
  for (const std::vector<std::size_t>& lives : sides) {
    if (!text.empty()) text += " against ";
    text += lives.size() > 1 ? "peers" : "peer";
    for (const std::size_t life : lives) text += ' ' + lives_[life].name;
  }
  return text;
}

void ConfirmedTicks::add(std::size_t life, Tick tick, std::uint64_t hash) {
  const auto at = static_cast<std::size_t>(tick);
  if (at >= ticks_.size()) ticks_.resize(at + 1);
  ticks_[at].push_back({life, hash});
}

void ConfirmedTicks::judge_given_up(const std::vector<Entry>& given_up, const std::vector<Entry>& others,
                                    ConfirmedCheck& check) const {
  if (others.empty()) return;
  for (const Entry& e : given_up) {
    ++check.given_up;
    if (e.hash != others[0].hash) ++check.given_up_unlike;
  }
}

ConfirmedCheck ConfirmedTicks::compare() const {
  ConfirmedCheck check;
  for (std::size_t i = 0; i < ticks_.size(); ++i) {
    const auto t = static_cast<Tick>(i);
    std::vector<Entry> entries;
    std::vector<Entry> given_up;
    for (const Entry& e : ticks_[i]) (lives_[e.life].superseded ? given_up : entries).push_back(e);
    judge_given_up(given_up, entries, check);
    if (entries.size() < 2) continue;
    const auto reaching = std::count_if(lives_.begin(), lives_.end(), [t](const Survey& s) {
      return !s.superseded && s.confirmed_from >= 0 && t >= s.confirmed_from && t <= s.last_tick;
    });
    if (static_cast<std::ptrdiff_t>(entries.size()) >= reaching) ++check.ticks;
    if (std::all_of(entries.begin(), entries.end(), [&](const Entry& e) { return e.hash == entries[0].hash; }))
      continue;
    ++check.mismatches;
    if (check.first_mismatch >= 0) continue;
    check.first_mismatch = t;
    check.who = sides(entries);
  }
  return check;
}

}  // namespace padr::report
