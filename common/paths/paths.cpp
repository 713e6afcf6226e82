#include "common/paths/paths.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace padr::node {

namespace {

/// More than any delay.
constexpr float kLast = 1e6F;

}  // namespace

void Paths::note_direct(PeerId from, Tick now) {
  ways_[from].direct = std::max(ways_[from].direct, now);
}

void Paths::on_reach(PeerId from, const wire::Reach& reach, Tick now) {
  Way& w = ways_[from];
  if (!w.known || reach.tick <= w.told_tick) return;
  w.told_tick = reach.tick;
  w.told_at = now;
  w.hears.clear();
  w.hears_carried = 0;
  for (const wire::Way& h : reach.heard) {
    if (h.carried) w.hears_carried |= only(h.slot);
    if (!h.carried) w.hears[h.slot] = h.delay;
  }
  w.at.clear();
  std::copy_if(reach.at.begin(), reach.at.end(), std::back_inserter(w.at), is_of_one_host);
}

void Paths::note_seen(PeerId who, const Endpoint& where) {
  if (ways_[who].known && is_of_one_host(where)) ways_[who].seen = where.place();
}

std::vector<Endpoint> Paths::addresses(PeerId of) const {
  std::vector<Endpoint> all = ways_[of].at;
  if (ways_[of].seen) all.push_back(*ways_[of].seen);
  return all;
}

// Silence while this peer was held up says nothing.
Tick Paths::unanswered(const Roster& roster, const std::vector<Link>& links, PeerId p) {
  return std::min(links[p].unanswered, roster.now - roster.seats[p].excused);
}

// Nor does it while p is carried that it is heard now.
bool Paths::hears(const Roster& roster, PeerId p) const {
  const Way& w = ways_[p];
  const Tick excused = w.by == kNoPeer ? roster.seats[p].excused : 0;
  return roster.now - std::max(w.direct, excused) < kUnheard;
}

bool Paths::needs_carrier(const Roster& roster, const std::vector<Link>& links, PeerId p) const {
  const Way& w = ways_[p];
  const Tick lasts = roster.now - w.since;
  if (w.by != kNoPeer && lasts < w.stay) return true;
  if (has_told(w, roster.now)) return !w.hears.contains(roster.self);
  if (w.by != kNoPeer && lasts < kFresh) return true;
  return !hears(roster, p) && unanswered(roster, links, p) >= kUnheard;
}

// By both links of it, as far as they are known; nothing if it cannot carry.
std::optional<float> Paths::cost(const Roster& roster, const std::vector<Link>& links, PeerId p, PeerId by) const {
  const Way& to = ways_[p];
  const Way& w = ways_[by];
  if (!w.known || !roster.seats[by].there() || w.by != kNoPeer) return std::nullopt;
  const bool reached = has_told(w, roster.now) ? w.hears.contains(roster.self) : hears(roster, by);
  if (!reached || unanswered(roster, links, by) >= kUnheard) return std::nullopt;
  const float first = links[by].delay + (to.has_failed(by, w.incarnation, roster.now) ? kLast : 0);
  if (!has_told(to, roster.now)) {
    // Of somebody who is gone each would send what it has for it through all others in turn.
    if ((links[p].unheard & only(by)) != 0) return std::nullopt;
    return first;
  }
  const auto second = to.hears.find(by);
  if (second == to.hears.end()) return std::nullopt;
  return first + static_cast<float>(second->second);
}

PeerId Paths::choose(const Roster& roster, const std::vector<Link>& links, PeerId p) const {
  PeerId best = kNoPeer;
  float least = 0;
  for (PeerId by = 0; by < roster.slots(); ++by) {
    if (by == p || by == roster.self) continue;
    auto c = cost(roster, links, p, by);
    if (!c) continue;
    if (by == ways_[p].by) *c -= kBetter;
    if (best != kNoPeer && *c >= least) continue;
    best = by;
    least = *c;
  }
  return best;
}

// Without word from it, it may well get what this member sends, and have chosen a carrier that is of no use itself: the
// two must not both change theirs at once, again and again.
bool Paths::leads_nowhere(const Roster& roster, const std::vector<Link>& links, PeerId p) const {
  const Way& w = ways_[p];
  const Tick lasts = roster.now - w.since;
  const bool gets_something = w.hears.contains(roster.self) || (w.hears_carried & only(roster.self)) != 0;
  if (has_told(w, roster.now)) return lasts >= kUnanswered && !gets_something;
  const Tick patience = (roster.self < p ? 1 : 2) * 2 * kUnanswered;
  return lasts >= patience && unanswered(roster, links, p) >= patience;
}

void Paths::Way::fail(std::uint32_t carrier, Tick now) {
  Failure& f = failed[by];
  if (f.incarnation != carrier) f = {carrier, 0, 0};
  if (now < f.until) return;
  f.until = now + (kFailed << std::min(f.times++, kMostDoublings));
}

bool Paths::Way::has_failed(PeerId carrier, std::uint32_t as, Tick now) const {
  const auto f = failed.find(carrier);
  return f != failed.end() && f->second.incarnation == as && now < f->second.until;
}

void Paths::change(Way& w, PeerId by, Tick now) {
  if (w.by == kNoPeer) w.stay = now - w.since < kRelapse && w.since > 0 ? std::clamp(2 * w.stay, kStay, kLongest) : 0;
  w.by = by;
  w.since = now;
}

std::vector<Paths::Change> Paths::advance(const Roster& roster, const std::vector<Link>& links) {
  std::vector<Change> changes;
  for (PeerId p = 0; p < roster.slots(); ++p) {
    const Seat& seat = roster.seats[p];
    Way& w = ways_[p];
    if (p == roster.self || !seat.reachable() || roster.departed(p)) {
      w = {};
    } else if (!w.known || w.incarnation != seat.incarnation) {
      w = {};
      w.known = true;
      w.incarnation = seat.incarnation;
      w.direct = roster.now;
    }
  }
  for (PeerId p = 0; p < roster.slots(); ++p) {
    Way& w = ways_[p];
    if (!w.known) continue;
    if (w.by != kNoPeer && leads_nowhere(roster, links, p)) w.fail(ways_[w.by].incarnation, roster.now);
    const bool needs = needs_carrier(roster, links, p);
    const PeerId by = needs ? choose(roster, links, p) : kNoPeer;
    if (by != w.by) change(w, by, roster.now);
    // A carrier is tried for whoever falls silent: most of those have ended, or it was a burst of losses. Whoever has
    // lost its carrier and finds no other one is not reached directly for that.
    const Tick lasts = roster.now - w.since;
    const bool is_news = by == kNoPeer ? !needs : lasts >= kReported && unanswered(roster, links, p) < lasts;
    if (!is_news || w.by == w.reported) continue;
    w.reported = w.by;
    changes.push_back({p, w.by});
  }
  return changes;
}

std::optional<Paths::Telling> Paths::due(const Roster& roster, const std::vector<Link>& links) {
  PeerSet heard = 0;
  PeerSet carried = 0;
  PeerSet concerned = 0;
  for (PeerId p = 0; p < roster.slots(); ++p) {
    if (!ways_[p].known) continue;
    const bool hears_it = hears(roster, p);
    if (hears_it) heard |= only(p);
    if (!hears_it && roster.silence(p) < kUnheard) carried |= only(p);
    if (!hears_it || ways_[p].by != kNoPeer) concerned |= only(p);
  }
  if (concerned != 0) left_to_tell_ = kTellAfterwards;
  if (left_to_tell_ == 0) return std::nullopt;
  concerned_ |= concerned;
  if (heard == heard_ && carried == carried_ && roster.now - told_ < kTellAgain) return std::nullopt;
  heard_ = heard;
  carried_ = carried;
  told_ = roster.now;
  Telling telling{{roster.now, {}}, concerned_};
  for (PeerId p = 0; p < roster.slots(); ++p) {
    if (((heard | carried) & only(p)) == 0) continue;
    const auto delay = static_cast<std::uint32_t>(std::lround(std::max(0.0F, links[p].delay)));
    telling.reach.heard.push_back({p, std::min(delay, wire::kMostDelay), (carried & only(p)) != 0});
  }
  if (concerned == 0 && --left_to_tell_ == 0) concerned_ = 0;
  return telling;
}

}  // namespace padr::node
