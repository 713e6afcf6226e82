#include "tools/capture/counted_updates.h"

#include <algorithm>

#include "common/sync/validation.h"

namespace padr::capture {

CountedUpdates::CountedUpdates(const SessionLog& session_log, const Scene& scene, int slots)
    : session_log_(session_log), scene_(scene), slots_(slots), retold_(session_log.retold) {}

void CountedUpdates::begin(int peers) {
  for (PeerId p = 0; p < peers; ++p) spans_[{p, 0}] = {};
  settle();
}

void CountedUpdates::begin(const sync::Transfer& transfer) {
  spans_.clear();
  for (const sync::Bundle& b : transfer.tail) retold_.try_emplace({b.peer, b.index}, b);
  for (PeerId p = 0; p < transfer.slots.size(); ++p) {
    const sync::Member& m = transfer.state.members[p];
    if (!m.present) continue;
    Span s;
    s.first = transfer.slots[p].first;
    spans_[{p, m.incarnation}] = s;
  }
  settle();
}

const sync::Bundle* CountedUpdates::find(const Incarnation& who, std::uint32_t index) const {
  const auto voice = session_log_.voices.find(who);
  if (voice != session_log_.voices.end()) {
    const auto own = voice->second.updates.find(index);
    if (own != voice->second.updates.end()) return &own->second;
  }
  const auto retold = retold_.find({who.slot, index});
  return retold == retold_.end() ? nullptr : &retold->second;
}

std::vector<CountedUpdates::Removal> CountedUpdates::removals() const {
  std::vector<Removal> all;
  const auto add = [&all](const Incarnation& by, const sync::Bundle& b, std::int64_t heard_ns) {
    for (const sync::Removal& r : b.removals) all.push_back({by, b.index, heard_ns, {r.slot, r.incarnation}, r.count});
  };
  for (const auto& [who, voice] : session_log_.voices)
    for (const auto& [index, b] : voice.updates) add(who, b, voice.last_ns);
  // Who a retold update is of besides its slot is not told: of the one who sat there when it was heard last.
  for (const auto& [key, b] : retold_) {
    Incarnation by{key.first, 0};
    std::int64_t heard = 0;
    for (const auto& [who, voice] : session_log_.voices)
      if (who.slot == key.first && !voice.marks.empty() && voice.marks.rbegin()->first > key.second &&
          (heard == 0 || voice.last_ns < heard)) {
        by = who;
        heard = voice.last_ns;
      }
    add(by, b, heard);
  }
  return all;
}

void CountedUpdates::settle() {
  ends_.clear();
  std::vector<Removal> all = removals();
  std::stable_sort(all.begin(), all.end(), [](const Removal& a, const Removal& b) { return a.heard_ns > b.heard_ns; });
  for (const Removal& r : all) {
    const auto void_from = ends_.find(r.by);
    if (void_from != ends_.end() && r.index >= void_from->second) continue;
    ends_.try_emplace(r.who, r.count);
  }
  admit();
  by_tick_.clear();
  for (auto& [who, span] : spans_) measure(who, span);
}

// Whoever was admitted may have admitted others: until nothing new comes of it.
void CountedUpdates::admit() {
  for (bool more = true; more;) {
    more = false;
    std::vector<std::pair<Incarnation, Span>> found;
    for (const auto& [who, span] : spans_) {
      const auto end = ends_.find(who);
      const auto look = [this, &found, end, first = span.first](const sync::Bundle& b) {
        if (!b.admission || b.admission->slot >= slots_ || b.index < first ||
            (end != ends_.end() && b.index >= end->second))
          return;
        Span s;
        s.first = b.admission->first;
        found.push_back({{b.admission->slot, b.admission->incarnation}, s});
      };
      const auto voice = session_log_.voices.find(who);
      if (voice != session_log_.voices.end())
        for (const auto& [index, b] : voice->second.updates) look(b);
      for (auto it = retold_.lower_bound({who.slot, 0}); it != retold_.end() && it->first.first == who.slot; ++it)
        look(it->second);
    }
    for (const auto& [who, span] : found) more |= spans_.try_emplace(who, span).second;
  }
}

void CountedUpdates::measure(const Incarnation& who, Span& span) {
  const auto end = ends_.find(who);
  if (end != ends_.end()) span.end = end->second;
  span.have = span.first;
  while (span.have < span.end) {
    const sync::Bundle* b = find(who, span.have);
    if (b == nullptr) break;
    sync::Bundle judged = *b;
    judged.peer = who.slot;
    if (sync::admit(judged, scene_, slots_) != sync::DropReason::kNone) {
      ++unbelievable_;
      break;
    }
    ++span.have;
    by_tick_[b->tick].try_emplace(who.slot, b);
    if (b->leave) span.end = span.have;
  }
  const auto voice = session_log_.voices.find(who);
  if (voice != session_log_.voices.end()) {
    for (const auto& [count, tick] : voice->second.marks)
      if (count <= span.have) span.complete = std::max(span.complete, tick);
    const auto beyond = voice->second.updates.lower_bound(span.end);
    if (end != ends_.end() && beyond != voice->second.updates.end()) span.other_world = beyond->second.tick;
  }
  if (span.have >= span.end) span.complete = kForever;
}

std::vector<sync::Bundle> CountedUpdates::at(Tick tick) const {
  std::vector<sync::Bundle> all;
  const auto found = by_tick_.find(tick);
  if (found == by_tick_.end()) return all;
  for (const auto& [slot, b] : found->second) {
    all.push_back(*b);
    all.back().peer = slot;
  }
  return all;
}

Tick CountedUpdates::complete(const Incarnation& who) const {
  const auto found = spans_.find(who);
  return found == spans_.end() ? -1 : found->second.complete;
}

std::string CountedUpdates::lacks(const Incarnation& who, bool& missing) const {
  const auto span = spans_.find(who);
  const auto voice = session_log_.voices.find(who);
  const std::string name = session_log_.names()(who);
  missing = false;
  if (span == spans_.end()) return "nothing tells how peer " + name + " came in";
  std::uint32_t promised = span->second.end == std::numeric_limits<std::uint32_t>::max() ? 0 : span->second.end;
  if (promised == 0 && voice != session_log_.voices.end() && !voice->second.marks.empty())
    promised = voice->second.marks.rbegin()->first;
  if (promised > span->second.have) {
    missing = true;
    return "update " + std::to_string(span->second.have) + " of peer " + name + " is not in the capture";
  }
  if (voice == session_log_.voices.end()) return "the capture has nothing of peer " + name;
  return "the capture has nothing of peer " + name + " after tick " + std::to_string(voice->second.last_tick);
}

bool CountedUpdates::counts(const SessionLog::Check& check) const {
  const auto span = spans_.find(check.by);
  if (span == spans_.end()) return false;
  // Who is removed has gone on in another world since its first update that never happened, and so have those who
  // were on its side.
  Tick other = span->second.other_world;
  if (ends_.contains(check.by))
    for (const auto& [who, s] : spans_) other = std::min(other, s.other_world);
  return check.tick <= other;
}

}  // namespace padr::capture
