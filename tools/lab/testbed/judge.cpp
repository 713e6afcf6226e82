#include "tools/lab/testbed/judge.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/lab/testbed/groups.h"

namespace padr::lab {
namespace {

/// Whose confirmed worlds lag more than this is not compared with those of others any more.
constexpr Tick kKept = 90 * kTicksPerSecond;
/// Ticks of updates that a peer may hold: confirmed waits some seconds for the lost, never much longer. What a member
/// has not acknowledged is kept, too, as long as others hear it.
constexpr Tick kMostLog = 60 * kTicksPerSecond;
/// How far confirmed may be behind when all has been quiet.
constexpr Tick kMostLag = 3 * kTicksPerSecond;
/// A difference that has not shown for so long, us, is another one when it shows again.
constexpr Micros kForgotten = 10 * kMicrosPerSecond;

std::string name(int person) {
  return "person " + std::to_string(person);
}

}  // namespace

Judge::Judge(VirtualNetwork& network) : network_(network) {
  network_.on_confirmed = [this](int person, int incarnation, const sync::FoldState& s, std::uint64_t hash) {
    confirmed(person, incarnation, s, hash);
  };
  network_.on_turn = [this](int person) { turn(person); };
}

void Judge::blame(const std::string& what) {
  if (violation_.empty())
    violation_ = "at " + std::to_string(static_cast<double>(network_.now()) / 1e6) + " s: " + what;
}

void Judge::confirmed(int person, int incarnation, const sync::FoldState& s, std::uint64_t hash) {
  if (liars_.contains(person)) return;
  heard_.push_back({person, incarnation, s.tick, hash});
  for (const world::Kinematics& k : s.world.entities)
    if (!is_finite(k.position) || !is_finite(k.velocity) || !std::isfinite(k.angle) || !std::isfinite(k.spin))
      blame(name(person) + " has confirmed a state that is not finite");
  for (std::size_t b = 0; b < s.authority.size(); ++b) {
    const PeerId holder = s.authority[b].holder();
    if (holder != kNoPeer && (holder >= s.members.size() || !s.members[holder].present))
      blame("body " + std::to_string(b) + " is owned by peer " + std::to_string(holder) + ", who is not there");
  }
}

// Nobody among honest peers has cause to cut anybody off.
void Judge::check_drops(int person) {
  const auto& dropped = network_.peer(person).replica().stats().dropped;
  for (const sync::DropReason why :
       {sync::DropReason::kMalformed, sync::DropReason::kEntity, sync::DropReason::kValue, sync::DropReason::kSignature,
        sync::DropReason::kCutOff, sync::DropReason::kPromise})
    if (dropped[static_cast<std::size_t>(why)] > 0)
      blame(name(person) +
            " has dropped an honest peer's datagram: " + std::string(sync::kDropNames[static_cast<std::size_t>(why)]));
}

void Judge::check_kept(int person, const node::Replica& n) {
  Tick most = kMostLog;
  for (PeerId q = 0; q < n.config().slots; ++q)
    if (q != n.self() && n.seat(q).there()) most = std::max(most, kMostLog + n.roster().silence(q));
  if (n.agreed().log().size() <= static_cast<std::size_t>(most)) {
    keeps_too_many_.erase(person);
    return;
  }
  // Who has just been evicted is waited for no longer, and its updates are forgotten in the next tick.
  const Tick since = keeps_too_many_.try_emplace(person, n.now()).first->second;
  if (n.now() > since + 1) blame(name(person) + " keeps updates of too many ticks");
}

void Judge::turn(int person) {
  if (liars_.contains(person)) return;
  const node::Participant& p = network_.peer(person);
  if (network_.sent_to_nowhere(person)) blame(name(person) + " has sent something to no address");
  if (p.playing() && liars_.empty()) check_drops(person);
  if (p.playing() && !p.replica().expelled()) {
    const node::Replica& n = p.replica();
    Record r{person, 0, {n.self(), n.config().incarnation}, {}};
    for (PeerId q = 0; q < n.config().slots; ++q)
      if (q != n.self() && n.seat(q).there()) r.others.emplace_back(q, n.seat(q).incarnation);
    for (const Heard& h : heard_) {
      if (h.incarnation != p.incarnation()) continue;
      r.hash = h.hash;
      compare(h.tick, r);
    }
    check_kept(person, n);
  }
  heard_.clear();
}

void Judge::compare(Tick t, Record r) {
  std::vector<Record>& at = records_[t];
  for (const Record& o : at) {
    const bool mutual = std::find(r.others.begin(), r.others.end(), o.self) != r.others.end() &&
                        std::find(o.others.begin(), o.others.end(), r.self) != o.others.end();
    if (!mutual || o.person == r.person) continue;
    judge_pair(t, o, r);
  }
  at.push_back(std::move(r));
  while (records_.begin()->first < records_.rbegin()->first - kKept) records_.erase(records_.begin());
}

// Where differences are tolerated, what counts is how long it takes until two confirm the same again.
void Judge::judge_pair(Tick t, const Record& a, const Record& b) {
  ++compared_;
  const std::pair persons = std::minmax(a.person, b.person);
  if (a.hash == b.hash) {
    differences_.erase(persons);
    return;
  }
  Difference& d = differences_.try_emplace(persons, Difference{network_.now(), network_.now()}).first->second;
  if (network_.now() - d.seen > kForgotten) d.since = network_.now();
  d.seen = network_.now();
  const Micros lasted = d.seen - d.since;
  longest_difference_ = std::max(longest_difference_, lasted);
  if (lasted >= tolerated_)
    blame("confirmed worlds of " + name(a.person) + " and " + name(b.person) + " differ at tick " + std::to_string(t) +
          (lasted > 0 ? ", for " + std::to_string(static_cast<double>(lasted) / 1e6) + " s now" : ""));
}

// Whoever is just being let in has no other incarnation yet than the one before. Once, a liar that came in anew as the
// script ended counted as an honest member.
bool Judge::is_liars(const node::Replica& seen_by, PeerId slot) const {
  return std::any_of(liars_.begin(), liars_.end(), [&](int liar) {
    if (!network_.runs(liar)) return false;
    const node::Participant& l = network_.peer(liar);
    const node::Seat& seat = seen_by.seat(slot);
    return l.channels() != nullptr && seat.at.key == l.channels()->key() &&
           (!l.playing() || seat.incarnation >= l.replica().config().incarnation);
  });
}

void Judge::final_check() {
  std::vector<int> all;
  for (int p = 0; p < network_.persons(); ++p)
    if (network_.runs(p) && !network_.leaving(p) && !network_.knocks_in_vain(p) && !liars_.contains(p))
      all.push_back(p);
  std::vector<std::vector<int>> parts{all};
  if (!liars_.empty()) parts = parts_that_know_of_each_other(all);
  std::size_t largest = 0;
  for (const std::vector<int>& part : parts) {
    check_part(part);
    largest = std::max(largest, part.size());
  }
  held_apart_ = static_cast<int>(all.size() - largest);
  // That they agree has been compared tick by tick; that there was something to compare has not.
  if (all.size() > 1 && compared_ == 0) blame("nothing could be compared");
}

std::vector<std::vector<int>> Judge::parts_that_know_of_each_other(std::vector<int> all) const {
  return groups_of(std::move(all), [this](int p, int q) { return network_.know_of_each_other(p, q); });
}

void Judge::check_part(const std::vector<int>& all) {
  for (const int p : all) {
    const node::Participant& a = network_.peer(p);
    if (!a.playing()) return blame(name(p) + " has not come in");
    if (a.returning()) return blame(name(p) + " is still on its way back");
    const node::Replica& n = a.replica();
    if (n.now() - n.agreed().confirmed().tick > kMostLag)
      return blame(name(p) + "'s confirmed world is " + std::to_string(n.now() - n.agreed().confirmed().tick) +
                   " ticks behind");
    if (n.stats().hash_mismatches > 0 && liars_.empty())
      return blame(name(p) + " has found another's confirmed world to differ");
    check_members(p, all);
  }
}

void Judge::check_members(int person, const std::vector<int>& all) {
  const node::Replica& n = network_.peer(person).replica();
  for (const int q : all) {
    if (q == person || !network_.peer(q).playing()) continue;
    const node::Replica& m = network_.peer(q).replica();
    const node::Seat& seen = n.seat(m.self());
    if (!seen.there() || seen.incarnation != m.config().incarnation)
      return blame(name(person) + " does not know " + name(q) + " as a member");
  }
  int there = 1;
  for (PeerId s = 0; s < n.config().slots; ++s)
    if (s != n.self() && n.seat(s).there() && !is_liars(n, s)) ++there;
  if (there != static_cast<int>(all.size()))
    blame(name(person) + " counts " + std::to_string(there) + " members of " + std::to_string(all.size()));
}

}  // namespace padr::lab
