// The last part of an eviction: all that any member has of the lost peer's updates is gathered and published, and then
// the eviction itself.
#include <algorithm>

#include "common/membership/evictions.h"

namespace padr::node {
namespace {

/// Fetches at once, and updates that a reply has at least, with signatures and one body each.
constexpr int kFetchesAtOnce = 4;
constexpr std::uint32_t kInOneReply = 6;

/// How deep updates lie in this one; see sync::kMaxPassing.
int passings(const sync::Bundle& b) {
  int deepest = 0;
  for (const sync::Bundle& inner : b.passed_on) deepest = std::max(deepest, 1 + passings(inner));
  return deepest;
}

}  // namespace

// An update that was here once and is no longer, all have confirmed: nobody else keeps it, either, and a member that
// says it lacks it is behind or lies.
bool Evictions::is_to_blame(PeerId p, const Missing& missing, const View& view) const {
  const auto of = lost_.find(missing.of);
  if (of == lost_.end()) return false;
  const auto said = of->second.have.find(p);
  if (said == of->second.have.end()) return false;  // it has come since: is_silent() waits for it
  const bool has = said->second > missing.index;
  return has != (missing.index < view.log.have(missing.of));
}

// Whether all other members say that they have the update that is missing, and later ones show that there is one.
bool Evictions::is_lacking(const View& view) const {
  const auto of = missing_ ? lost_.find(missing_->of) : lost_.end();
  if (of == lost_.end() || of->second.fetched.upper_bound(missing_->index) == of->second.fetched.end()) return false;
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (counts(p, view) && !is_to_blame(p, *missing_, view)) return false;
  return true;
}

// Whether p's reply about a lost peer has been awaited for too long. Time in which this peer was held up does not
// count: it could not hear the replies.
bool Evictions::is_silent(PeerId p, const View& view) const {
  const Tick timeout = (view.returning & only(p)) != 0 ? kReturning : kWithheld;
  return std::any_of(lost_.begin(), lost_.end(), [&](const auto& entry) {
    const Lost& lost = entry.second;
    const auto asked = lost.asked.find(p);
    const Tick since = asked != lost.asked.end() ? asked->second : lost.grounds.now;
    return !lost.have.contains(p) && view.roster.now - std::max(since, view.roster.seats[p].excused) >= timeout;
  });
}

std::vector<PeerId> Evictions::withholding(const View& view) const {
  std::vector<PeerId> who;
  if (lost_.empty() || ordered()) return who;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!counts(p, view)) continue;
    const bool unsent = missing_ && is_to_blame(p, *missing_, view) &&
                        view.roster.now - std::max(moved_, view.roster.seats[p].excused) >= kUnsent;
    if (is_silent(p, view) || unsent) who.push_back(p);
  }
  return who;
}

bool Evictions::all_answered(const View& view) const {
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!counts(p, view)) continue;
    for (const auto& [slot, lost] : lost_)
      if (!lost.have.contains(p)) return false;
  }
  return true;
}

// Whether all updates of p are here that some member has and another may lack.
bool Evictions::gather(PeerId p, Lost& lost, const View& view, Commands& out) {
  const sync::UpdateLog& log = view.log;
  lost.least = lost.most = log.have(p);
  for (const auto& [q, have] : lost.have) {
    if (!counts(q, view)) continue;
    lost.least = std::min(lost.least, have);
    lost.most = std::max(lost.most, have);
  }
  // Of two updates with one number, this peer has filed its own already: it has to publish that one.
  for (const sync::Bundle& b : log.of(p, lost.least)) lost.fetched.insert_or_assign(b.index, b);
  const sync::Bundle* before = lost.least > 0 ? log.find(p, lost.least - 1) : nullptr;
  Tick newest = before != nullptr ? before->tick : -1;
  for (std::uint32_t i = lost.least; i < lost.most; ++i) {
    const auto found = lost.fetched.find(i);
    if (found != lost.fetched.end()) {
      // No log takes two updates of one tick, and no datagram one that lies deeper than kMaxPassing. A peer that signs
      // such has its log ended; whoever has more of it joins anew.
      if (found->second.tick <= newest || passings(found->second) >= sync::kMaxPassing) {
        lost.most = i;
        break;
      }
      newest = found->second.tick;
      if (found->second.tick >= view.roster.now) return false;  // its clock was ahead
      continue;
    }
    missing_ = {p, i};
    fetch(p, lost, i, view, out);
    return false;
  }
  return view.is_over(p, lost.most);
}

// A member may count an update without keeping it: a late joiner has it in the state that it began with. So the members
// are asked one after the other. A reply fills one datagram, and a busy peer publishes an update each tick: what lies
// behind the next replies is asked for, too.
void Evictions::fetch(PeerId p, Lost& lost, std::uint32_t index, const View& view, Commands& out) {
  if (view.roster.now - asked_ < kAskAgain) return;
  asked_ = view.roster.now;
  for (int n = 0; n < kFetchesAtOnce && index < lost.most; ++n, index = lost.next(index + kInOneReply)) {
    std::vector<PeerId> had;
    for (const auto& [q, have] : lost.have)
      if (have > index && counts(q, view)) had.push_back(q);
    if (had.empty()) return;
    out.send(view.roster.seats[had[lost.fetches++ % had.size()]].at, wire::Fetch{p, lost.incarnation, index});
  }
}

void Evictions::bury(Commands& out) {
  sync::Bundle last;
  for (auto& [p, lost] : lost_) {
    for (std::uint32_t i = lost.least; i < lost.most; ++i) {
      sync::Bundle order;
      order.passed_on.push_back(lost.fetched.at(i));
      out.publish(order);
    }
    last.removals.push_back({p, lost.incarnation, lost.most});
    lost.ordered = true;
  }
  out.publish(last);
}

bool Evictions::is_forsaken_by(const std::vector<PeerId>& who, const View& view) const {
  std::size_t members = 0;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!withholds_.contains(p) && !counts(p, view)) continue;
    const bool silent = std::find(who.begin(), who.end(), p) != who.end() && is_silent(p, view);
    if (!silent && !withholds_.contains(p)) return false;
    ++members;
  }
  return members > 1;
}

// A member that was not waited for does not take the removal, as it has not been asked. It joins anew.
void Evictions::go_on_without(const View& view, Commands& out) {
  const std::vector<PeerId> who = withholding(view);
  behind_ = forsaken_ = false;
  if (who.empty()) return;
  behind_ = is_lacking(view);
  forsaken_ = is_forsaken_by(who, view);
  if (behind_ || forsaken_) return;
  for (const PeerId p : who) {
    withholds_.insert(p);
    out.tell({.kind = SessionEvent::Kind::kWithholds, .peer = p});
  }
  moved_ = view.roster.now;
}

}  // namespace padr::node
