#include "tools/lab/testbed/judge.h"

#include <algorithm>
#include <cmath>

namespace padr::lab {
namespace {

/// Whose confirmed worlds lag more than this is not compared with those of others any more.
constexpr Tick kKept = 90 * kTicksPerSecond;
/// Ticks of updates that a peer may hold: confirmed waits some seconds for the lost, never much longer.
constexpr std::size_t kMostLog = 60 * kTicksPerSecond;
/// How far confirmed may be behind when all has been quiet.
constexpr Tick kMostLag = 3 * kTicksPerSecond;

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
  for (const sync::DropReason why : {sync::DropReason::kMalformed, sync::DropReason::kEntity, sync::DropReason::kValue,
                                     sync::DropReason::kSignature, sync::DropReason::kCutOff})
    if (dropped[static_cast<std::size_t>(why)] > 0)
      blame(name(person) +
            " has dropped an honest peer's datagram: " + std::string(sync::kDropNames[static_cast<std::size_t>(why)]));
}

void Judge::turn(int person) {
  if (liars_.contains(person)) return heard_.clear();
  const node::Participant& p = network_.peer(person);
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
    if (n.agreed().log().size() > kMostLog) blame(name(person) + " keeps updates of too many ticks");
  }
  heard_.clear();
}

void Judge::compare(Tick t, Record r) {
  std::vector<Record>& at = records_[t];
  for (const Record& o : at) {
    const bool mutual = std::find(r.others.begin(), r.others.end(), o.self) != r.others.end() &&
                        std::find(o.others.begin(), o.others.end(), r.self) != o.others.end();
    if (!mutual || o.person == r.person) continue;
    ++compared_;
    if (o.hash != r.hash)
      blame("confirmed worlds of " + name(o.person) + " and " + name(r.person) + " differ at tick " +
            std::to_string(t));
  }
  at.push_back(std::move(r));
  while (records_.begin()->first < records_.rbegin()->first - kKept) records_.erase(records_.begin());
}

void Judge::final_check() {
  std::vector<int> all;
  for (int p = 0; p < network_.persons(); ++p)
    if (network_.runs(p) && !network_.leaving(p) && !network_.knocks_in_vain(p)) all.push_back(p);
  for (const int p : all) {
    const node::Participant& a = network_.peer(p);
    if (!a.playing()) return blame(name(p) + " has not come in");
    if (a.returning()) return blame(name(p) + " is still on its way back");
    const node::Replica& n = a.replica();
    if (n.now() - n.agreed().confirmed().tick > kMostLag)
      return blame(name(p) + "'s confirmed world is " + std::to_string(n.now() - n.agreed().confirmed().tick) +
                   " ticks behind");
    if (n.stats().hash_mismatches > 0) return blame(name(p) + " has found another's confirmed world to differ");
    for (const int q : all) {
      if (q == p || !network_.peer(q).playing()) continue;
      const node::Replica& m = network_.peer(q).replica();
      const node::Seat& seen = n.seat(m.self());
      if (!seen.there() || seen.incarnation != m.config().incarnation)
        return blame(name(p) + " does not know " + name(q) + " as a member");
    }
    int there = 1;
    for (PeerId s = 0; s < n.config().slots; ++s)
      if (s != n.self() && n.seat(s).there()) ++there;
    if (there != static_cast<int>(all.size()))
      return blame(name(p) + " counts " + std::to_string(there) + " members of " + std::to_string(all.size()));
  }
  // That they agree has been compared tick by tick; that there was something to compare has not.
  if (all.size() > 1 && compared_ == 0) blame("nothing could be compared");
}

}  // namespace padr::lab
