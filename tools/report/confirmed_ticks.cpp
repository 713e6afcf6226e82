#include "tools/report/confirmed_ticks.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

namespace padr::report {

/// "peers 0 2 against peer 1"
std::string ConfirmedTicks::sides(const std::vector<Entry>& entries) const {
  std::map<std::uint64_t, std::vector<std::size_t>> by_hash;
  for (const Entry& e : entries) by_hash[e.hash].push_back(e.incarnation);
  std::vector<std::vector<std::size_t>> sides;
  for (auto& [hash, incarnations] : by_hash) {
    std::sort(incarnations.begin(), incarnations.end());
    sides.push_back(std::move(incarnations));
  }
  std::sort(sides.begin(), sides.end());
  std::string text;
  for (const std::vector<std::size_t>& incarnations : sides) {
    if (!text.empty()) text += " against ";
    text += incarnations.size() > 1 ? "peers" : "peer";
    for (const std::size_t incarnation : incarnations) text += ' ' + incarnations_[incarnation].name;
  }
  return text;
}

void ConfirmedTicks::add(std::size_t incarnation, Tick tick, std::uint64_t hash) {
  const auto at = static_cast<std::size_t>(tick);
  if (at >= ticks_.size()) ticks_.resize(at + 1);
  ticks_[at].push_back({incarnation, hash});
}

std::set<std::size_t> ConfirmedTicks::given_up() const {
  // Who is declared gone by many, and declares them gone, is in the smaller part.
  std::vector<std::size_t> by(incarnations_.size());
  for (const auto& [who, declarer] : declared_gone_) ++by[who];
  const auto first_beside = [this](std::size_t who) {
    std::size_t n = 0;
    while (declared_gone_.contains({who, n}) || declared_gone_.contains({n, who})) ++n;
    return n;
  };
  const auto rank = [&](std::size_t who) { return std::pair(by[who], first_beside(who)); };
  std::set<std::size_t> all;
  for (const auto& [who, declarer] : declared_gone_)
    if (rank(who) > rank(declarer)) all.insert(who);
  for (std::size_t n = 0; n < incarnations_.size(); ++n)
    if (incarnations_[n].superseded) all.insert(n);
  return all;
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
  const std::set<std::size_t> gone = given_up();
  for (std::size_t i = 0; i < ticks_.size(); ++i) {
    const auto t = static_cast<Tick>(i);
    std::vector<Entry> entries;
    std::vector<Entry> later_gone;
    for (const Entry& e : ticks_[i]) (gone.contains(e.incarnation) ? later_gone : entries).push_back(e);
    judge_given_up(later_gone, entries, check);
    if (entries.size() < 2) continue;
    std::size_t reaching = 0;
    for (std::size_t n = 0; n < incarnations_.size(); ++n) {
      const Survey& s = incarnations_[n];
      if (!gone.contains(n) && s.confirmed_from >= 0 && t >= s.confirmed_from && t <= s.last_tick) ++reaching;
    }
    if (entries.size() >= reaching) ++check.ticks;
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
