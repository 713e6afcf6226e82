#include "tools/lab/testbed/harm.h"

#include <algorithm>
#include <utility>

#include "tools/lab/testbed/groups.h"

namespace padr::lab {
namespace {

/// Whoever was out of reach lately may have been declared gone for it.
constexpr Micros kLately = 10 * kMicrosPerSecond;

std::string title(int person) {
  return "person " + std::to_string(person);
}

}  // namespace

HarmMeter::HarmMeter(const VirtualNetwork& network, const std::set<int>& liars, const HarmBounds& bounds)
    : network_(network), liars_(liars), bounds_(bounds) {}

void HarmMeter::blame(const std::string& what) {
  if (violation_.empty())
    violation_ = "at " + std::to_string(static_cast<double>(network_.now()) / 1e6) + " s: " + what;
}

void HarmMeter::note(Micros lasted, Micros& longest, Micros bound, const std::string& what) {
  longest = std::max(longest, lasted);
  if (lasted > bound) blame(what + " for " + std::to_string(static_cast<double>(lasted) / 1e6) + " s");
}

bool HarmMeter::plays(int person) const {
  return network_.runs(person) && !network_.leaving(person) && network_.peer(person).playing();
}

bool HarmMeter::know_each_other(int a, int b) const {
  const node::Replica& n = network_.peer(a).replica();
  const node::Replica& m = network_.peer(b).replica();
  const auto knows = [](const node::Replica& x, const node::Replica& y) {
    const node::Seat& seat = x.seat(y.self());
    return seat.there() && seat.incarnation == y.config().incarnation;
  };
  return n.self() != m.self() && knows(n, m) && knows(m, n);
}

// Those whom a liar alone has let in know of nobody else, and nobody else of them: neither can find the others.
std::set<int> HarmMeter::largest_groups() const {
  std::vector<int> all;
  for (int p = 0; p < network_.persons(); ++p)
    if (honest(p) && plays(p)) all.push_back(p);
  std::vector<std::vector<int>> parts{all};
  if (!liars_.empty()) parts = groups_of(all, [this](int a, int b) { return network_.know_of_each_other(a, b); });
  std::set<int> found;
  for (std::vector<int>& part : parts) {
    std::vector<int> largest;
    for (std::vector<int>&group : groups_of(std::move(part), [this](int a, int b) { return know_each_other(a, b); }))
      if (group.size() > largest.size()) largest = std::move(group);
    found.insert(largest.begin(), largest.end());
  }
  return found;
}

bool HarmMeter::is_reachable(int person) const {
  std::vector<int> others;
  for (int q = 0; q < network_.persons(); ++q)
    if (q != person && plays(q) && !network_.paused(q)) others.push_back(q);
  const auto reaches = [&](int from, int to) {
    return network_.connected(from, to) || std::any_of(others.begin(), others.end(), [&](int by) {
             return by != from && by != to && network_.connected(from, by) && network_.connected(by, to);
           });
  };
  return !network_.paused(person) &&
         std::all_of(others.begin(), others.end(), [&](int q) { return reaches(person, q) && reaches(q, person); });
}

// Whoever was declared gone is not told so: others know it. Those who join anew themselves may be the ones who are
// gone.
std::vector<int> HarmMeter::evictors_of(int person) const {
  const node::Replica& n = network_.peer(person).replica();
  std::vector<int> found;
  for (int q = 0; q < network_.persons(); ++q) {
    if (q == person || !honest(q) || !plays(q) || network_.peer(q).returning()) continue;
    const node::Seat& seat = network_.peer(q).replica().seat(n.self());
    if (seat.incarnation == n.config().incarnation && seat.presence == node::Presence::kAbsent) found.push_back(q);
  }
  return found;
}

bool HarmMeter::was_reachable(int person) {
  return network_.now() - watched_[person].unreachable_at > kLately;
}

void HarmMeter::look() {
  const std::set<int> in = largest_groups();
  for (int p = 0; p < network_.persons(); ++p)
    if (plays(p) && !is_reachable(p)) watched_[p].unreachable_at = network_.now();
  for (int p = 0; p < network_.persons(); ++p) {
    if (!honest(p)) continue;
    if (plays(p))
      look_at(p, in.contains(p));
    else
      look_at_ended(p);
  }
}

void HarmMeter::look_at(int person, bool in) {
  const node::Participant& peer = network_.peer(person);
  const node::Replica& n = peer.replica();
  const Micros now = network_.now();
  Watched& w = watched_[person];
  if (w.incarnation >= 0 && peer.incarnation() > w.incarnation) ++harm_.begun_anew;
  const bool fresh = w.incarnation < 0;
  const bool changed = peer.incarnation() != w.incarnation;
  w.incarnation = peer.incarnation();
  if (changed) w.evicted = false;
  if (!w.evicted) look_for_eviction(person, w);
  if (in) w.was_in = true;
  const Tick confirmed = n.agreed().confirmed().tick;
  if (fresh || network_.paused(person)) w.confirmed_at = w.in_at = w.stepped_at = now;
  if (changed || n.now() != w.now) w.stepped_at = now;
  if (confirmed != w.confirmed) w.confirmed_at = now;
  if (in || !w.was_in || network_.divided()) w.in_at = now;
  w.now = n.now();
  w.confirmed = confirmed;
  note(now - w.confirmed_at, harm_.unconfirmed, bounds_.unconfirmed, title(person) + " has confirmed nothing");
  note(now - w.in_at, harm_.out, bounds_.out, title(person) + " has been out");
  note(now - w.stepped_at, harm_.stalled, bounds_.stalled, title(person) + "'s live world has stood still");
  look_for_bans(person);
}

void HarmMeter::look_for_eviction(int person, Watched& w) {
  const std::vector<int> by = evictors_of(person);
  if (by.empty()) return;
  w.evicted = true;
  ++harm_.evicted;
  const auto reached = [this](int q) { return was_reachable(q); };
  if (was_reachable(person) && std::any_of(by.begin(), by.end(), reached)) ++harm_.evicted_reachable;
}

// No honest peer gives another cause to cut it off.
void HarmMeter::look_for_bans(int person) {
  const node::Replica& n = network_.peer(person).replica();
  for (PeerId q = 0; q < n.config().slots; ++q) {
    if (q == n.self() || n.link(q).cut_offs == 0 || !n.seat(q).there()) continue;
    for (int other = 0; other < network_.persons(); ++other) {
      if (!honest(other) || !plays(other)) continue;
      const node::Replica& m = network_.peer(other).replica();
      if (m.self() == q && m.config().incarnation == n.seat(q).incarnation)
        blame(title(person) + " has cut off " + title(other) + ", which is honest");
    }
  }
}

// A joiner that does not come in gives up some time. Whoever asks the liar, or somebody who is gone, may have to.
void HarmMeter::look_at_ended(int person) {
  Watched& w = watched_[person];
  const node::Participant& peer = network_.peer(person);
  if (w.ended || network_.runs(person) || network_.leaving(person) || peer.playing()) return;
  w.ended = true;
  if (!peer.failed()) return;
  ++harm_.kept_out;
  const std::string& why = peer.session().failure();
  if (why.find("cut off") != std::string::npos) blame(title(person) + ", which is honest, was refused: " + why);
}

}  // namespace padr::lab
