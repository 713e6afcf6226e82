// Which of two parts wins: what this peer knows of the other one, and how it weighs that against its own.
#include <algorithm>
#include <utility>

#include "common/membership/partition_merge.h"

namespace padr::node {

bool PartitionMerge::comes_first(const Side& a, const Side& b) {
  if (a.size() != b.size()) return a.size() > b.size();
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                      [](const wire::Seat& x, const wire::Seat& y) {
                                        return std::pair(x.slot, x.incarnation) < std::pair(y.slot, y.incarnation);
                                      });
}

// The two parts of a partition have no peer in common. If a peer seems to be in both, one of the lists is out of date.
bool PartitionMerge::outranks(const Side& a, const Side& b) {
  const auto is_in_both = [&](const wire::Seat& s) { return std::find(a.begin(), a.end(), s) != a.end(); };
  return std::none_of(b.begin(), b.end(), is_in_both) && comes_first(a, b);
}

// Since they parted, both may have given one slot and one incarnation to somebody. Keys tell these two apart.
bool PartitionMerge::is_disjoint(const Side& theirs, const Side& us, const View& view) const {
  return std::none_of(us.begin(), us.end(), [&](const wire::Seat& s) {
    const PublicKey& ours = s.slot == view.roster.self ? own_key_ : view.roster.seats[s.slot].at.key;
    const auto is_another = [&](const Witness& w) {
      return w.slot == s.slot && w.incarnation == s.incarnation && w.from.key != ours;
    };
    return std::find(theirs.begin(), theirs.end(), s) != theirs.end() &&
           std::none_of(witnesses_.begin(), witnesses_.end(), is_another);
  });
}

bool PartitionMerge::lists(const Side& side, const Witness& w) {
  return std::any_of(side.begin(), side.end(),
                     [&](const wire::Seat& s) { return s.slot == w.slot && s.incarnation == w.incarnation; });
}

// A liar in a part that no longer counts it would be one more of them to us than to themselves, and each part might
// yield.
bool PartitionMerge::is_disowned(const Witness& sender, Tick now) const {
  bool has_others = false;
  for (const Witness& w : witnesses_) {
    if (&w == &sender || now - w.heard >= kLately || !lists(sender.members, w)) continue;
    if (lists(w.members, sender)) return false;
    has_others = true;
  }
  return has_others;
}

bool PartitionMerge::is_own(const Endpoint& from, PeerId sender, std::uint32_t incarnation, const View& view) const {
  const bool is_another = from.has_key() && own_key_ != PublicKey{} && from.key != own_key_;
  return sender == view.roster.self && incarnation == view.roster.incarnation && !is_another;
}

PartitionMerge::Gone PartitionMerge::known(const Remembered& r, const View& view) const {
  Gone known = r.gone;
  if (!was_member(known) && r.before < known.removed && is_lonely(kStrangers, view)) known.since = r.before;
  return known;
}

// The peers of that part that have sent a Probe lately and, by our own log, were members until they were evicted or
// left, or are until now. Whoever left to join anew may have found other members than we did. For a peer that has been
// alone for long those count, too, that its former incarnation knew, or of which it was only told.
std::vector<sync::Transfer::Gone> PartitionMerge::evidence(const Side& side, const View& view) const {
  std::vector<Gone> all;
  for (const Witness& w : witnesses_) {
    if (!lists(side, w) || view.roster.now - w.heard >= kLately) continue;
    const auto gone =
        std::find_if(gone_.begin(), gone_.end(), [&](const Remembered& r) { return r.gone.at.key == w.from.key; });
    const auto disowned = disowned_by_.find(w.slot);
    if (gone != gone_.end())
      all.push_back(known(*gone, view));
    else if (disowned != disowned_by_.end() && disowned->second == w.incarnation &&
             view.roster.seats[w.slot].at.key == w.from.key)
      all.push_back({w.from, since(w.slot, view), view.roster.now});
    else if (is_lonely(kAlone, view))
      for (const Told& t : told_)
        if (t.at.key == w.from.key) all.push_back({w.from, t.since, t.since});
  }
  return all;
}

bool PartitionMerge::is_witness(const Endpoint& from, const wire::Probe& probe, const View& view) const {
  if (!session_.config.sealed) return true;
  const std::vector<Gone> all = evidence(probe.members, view);
  return std::any_of(all.begin(), all.end(), [&](const Gone& g) { return g.at.key == from.key; });
}

bool PartitionMerge::is_outranked(const wire::Probe& probe, const Side& us, const View& view) const {
  if (!session_.config.sealed) return outranks(probe.members, us);
  if (!has_stronger_evidence(probe, us, view)) return false;
  // Each part goes by what it knows, so each may yield to the other. Then the larger one stays.
  return !probe.yields || is_larger(probe, us, evidence(probe.members, view).size(), us.size(), view);
}

// Once, whoever had played on alone for two minutes went over to the founder that woke up then, and lost all that.
bool PartitionMerge::has_slept_through(const wire::Probe& probe, const View& view) const {
  if (!is_awake_for_less(kDrowsy, view)) return false;
  std::size_t own = 1;
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (p != view.roster.self && view.roster.seats[p].there() && !disowns_us(p, view)) ++own;
  return (session_.config.sealed ? evidence(probe.members, view).size() : probe.members.size()) >= own;
}

// A newcomer counts in its own part only, and seniority may then keep the smaller part from joining the larger one for
// ever. A single witness may be a liar, and moves nobody but who has been alone for longer.
bool PartitionMerge::is_larger_for_long(const wire::Probe& probe, const Side& us, const View& view) {
  if (!session_.config.sealed) return false;
  const std::vector<Gone> witnesses = evidence(probe.members, view);
  // Newcomers count in neither part, as each part must come to the same, unless both parts yield.
  const Tick split = split_from(witnesses);
  const auto is_known = [&](const wire::Seat& s) { return since(s.slot, view) <= split; };
  const auto own = probe.yields ? us.size() : static_cast<std::size_t>(std::count_if(us.begin(), us.end(), is_known));
  if (!is_larger(probe, us, witnesses.size(), own, view)) return false;
  const Tick now = view.roster.now;
  if (now - larger_seen_ >= kLately) larger_since_ = now;
  larger_seen_ = now;
  return now - larger_since_ >= (witnesses.size() > 1 ? kStrangers : kAlone);
}

bool PartitionMerge::is_larger(const wire::Probe& probe, const Side& us, std::size_t witnesses, std::size_t own,
                               const View& view) const {
  if (witnesses != own) return witnesses > own;
  return is_disjoint(probe.members, us, view) && comes_first(probe.members, us);
}

// Somebody whose place only is known was not in this part when it split, so that says nothing of when that was.
Tick PartitionMerge::split_from(const std::vector<Gone>& witnesses) {
  Tick split = kNever;
  for (const Gone& g : witnesses)
    if (was_member(g)) split = std::min(split, g.removed);
  return split;
}

bool PartitionMerge::has_stronger_evidence(const wire::Probe& probe, const Side& us, const View& view) const {
  const bool disjoint = is_disjoint(probe.members, us, view);
  const std::vector<Gone> witnesses = evidence(probe.members, view);
  if (!disjoint || witnesses.empty()) return false;
  Tick split = kNever;
  for (const Gone& g : witnesses) split = std::min(split, g.removed);
  // Nothing shows which part is the larger one, in neither of them perhaps: then they may have their word, after a
  // while. Of two that are alone the other one may know nothing of this one, and wait for ever.
  if (std::none_of(witnesses.begin(), witnesses.end(), was_member))
    return view.roster.now - split >= kStrangers &&
           (is_larger(probe, us, witnesses.size(), us.size(), view) || is_lonely(kLonely, view));
  const auto weigh = [&](Tick margin) {
    Weights w;
    for (const Gone& g : witnesses)
      if (g.since + margin <= g.removed) w.theirs.add(g.since);
    for (const wire::Seat& s : us)
      if (since(s.slot, view) + margin <= split) w.ours.add(since(s.slot, view));
    return w;
  };
  // If most of those that were members when the two parts evicted each other had not been so for long, all of them
  // count. Each part must come to the same: its newcomers since then, which the other cannot know, do not count here.
  const Weights members = weigh(0);
  const Weights known = weigh(kMayBeUnknown);
  const bool few = 2 * known.peers() < members.peers() || known.peers() == 0;
  const auto& [theirs, ours] = few ? members : known;
  if (members.peers() == 0) return false;
  if (theirs.peers != ours.peers) return theirs.peers > ours.peers;
  // What a single witness says may be a lie: it moves no larger part at once. If it is true, it joins that part itself.
  if (theirs.peers == 1 && us.size() > probe.members.size()) return false;
  if (stalled_ && theirs.peers > 1) return true;
  if (theirs.senior != ours.senior) return theirs.senior < ours.senior;
  return comes_first(probe.members, us);
}

}  // namespace padr::node
