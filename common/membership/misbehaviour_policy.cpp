#include "common/membership/misbehaviour_policy.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "common/membership/evictions.h"
#include "common/membership/signers.h"

namespace padr::node {
namespace {

using sync::Bundle;
using sync::DropReason;

/// Time for which two peers may take themselves for the coordinator, or their orders be under way.
constexpr Tick kHandOver = 10 * kTicksPerSecond;

/// Reasons that no honest peer causes, whatever the receiver knows, and under a seal no network fault either. All other
/// rules depend on the receiver's clock or log, and a liar who tells different peers different things can make honest
/// peers break them.
bool is_nonsense(DropReason why) {
  return why == DropReason::kMalformed || why == DropReason::kEntity || why == DropReason::kValue ||
         why == DropReason::kSignature;
}

/// The slots whose occupants' removals or farewells come earlier in the datagram that is being judged.
void note_freed(const Bundle& b, PeerSet& freed) {
  if (b.leave) freed |= only(b.peer);
  for (const sync::Removal& r : b.removals) freed |= only(r.slot);
  for (const Bundle& lost : b.passed_on) note_freed(lost, freed);
}

/// Whether the slot of an admission is free, as far as this peer can tell: nobody is thrown out by it.
bool is_free(const sync::Admission& a, const View& view, PeerSet freed) {
  const Roster& r = view.roster;
  if ((freed & only(a.slot)) != 0) return true;
  if (a.slot == r.self) return !r.member || r.leaving || a.incarnation == r.incarnation;
  const Seat& s = r.seats[a.slot];
  // Whoever is convicted may have said goodbye to the coordinator only.
  return !s.there() || s.frozen || s.given_up_for_good || a.incarnation <= s.incarnation;
}

/// Whether x may be the coordinator: no more senior peer is alive, as far as this peer can tell.
bool may_coordinate(PeerId x, const View& view, const Evictions& evictions) {
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!view.roster.is_senior(p, x)) continue;
    if (p == view.roster.self) {
      if (!view.roster.leaving) return false;
      continue;
    }
    const Seat& n = view.roster.seats[p];
    if (n.there() && !n.frozen && !Evictions::suspected(view, p) && !evictions.answered(x, p)) return false;
  }
  return true;
}

/// Whether an admission makes its peer the most junior: with a low incarnation it would be the next coordinator. Two
/// coordinators may assign numbers at the same time, and a liar may tell late of whom it has admitted.
bool is_junior(const sync::Admission& a, Tick told, const View& view) {
  const Roster& r = view.roster;
  for (PeerId p = 0; p < r.slots(); ++p) {
    // A transfer tells when a peer was first admitted; it was in this slot before this peer was admitted.
    const Seat& s = r.seats[p];
    const Tick known = p == r.self ? r.in_since : std::max({r.in_since, s.since, s.seated});
    const bool there = p == r.self || s.there();
    if (there && p != a.slot && known + kHandOver < told && a.incarnation <= r.incarnation_of(p)) return false;
  }
  return true;
}

bool may_pass_on(const Bundle& lost, const Bundle& by, const View& view, const Evictions& evictions, bool sealed) {
  const Seat& n = view.roster.seats[lost.peer];
  // A known update changes nothing, and all of our own are known.
  if (view.log.knows(lost.peer, lost.index)) return true;
  if (lost.peer == view.roster.self) return lost.index < n.first;
  // Its own signature is checked, and then it does not matter who passes it on.
  if (sealed && sayer(lost.peer, lost.index, view, {})) return true;
  if (evictions.answered(by.peer, lost.peer)) return true;
  const bool of_nobody_now = lost.index < n.first || !n.there() || n.frozen;
  return of_nobody_now && may_coordinate(by.peer, view, evictions);
}

bool admitter_is_lost(const Bundle& by, const View& view) {
  const PeerId admitter = view.roster.admitted_by;
  if (admitter == kNoPeer) return false;
  const Seat& n = view.roster.seats[admitter];
  return !n.there() || n.since > view.roster.in_since ||
         std::any_of(by.removals.begin(), by.removals.end(),
                     [admitter](const sync::Removal& r) { return r.slot == admitter; });
}

/// The peer that admitted us may have been lost before the others heard of us. Then nobody could poll us about it, nor
/// about a peer that was lost with it.
bool could_not_ask(const Bundle& by, PeerId lost, const View& view, const Evictions& evictions) {
  return by.tick <= view.roster.in_since + Evictions::kWithheld && admitter_is_lost(by, view) &&
         Evictions::suspected(view, lost) && may_coordinate(by.peer, view, evictions);
}

/// Whether its peer may give this order. Updates that an order passes on are not judged again.
bool is_lawful(const Bundle& b, const View& view, const Evictions& evictions, PeerSet freed, bool sealed) {
  const bool order = b.admission || !b.removals.empty() || !b.passed_on.empty();
  if (!order || view.log.knows(b.peer, b.index)) return true;
  // For an order from before our admission, other members were polled: one of them has to relay it, unless its peer has
  // let us in. Without a key nothing shows who has told what.
  if (!view.roster.member || b.tick <= view.roster.in_since) return !sealed || b.peer == view.roster.admitted_by;
  for (const sync::Removal& r : b.removals)
    if (!evictions.answered(b.peer, r.slot, r.incarnation) && !could_not_ask(b, r.slot, view, evictions)) return false;
  if (b.admission && !(may_coordinate(b.peer, view, evictions) && is_free(*b.admission, view, freed) &&
                       is_junior(*b.admission, b.tick, view)))
    return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(),
                     [&](const Bundle& lost) { return may_pass_on(lost, b, view, evictions, sealed); });
}

/// Whether another member has taken this order, which it can only have judged by what it knew itself. What a rule
/// allows depends on who has heard what, but all members have to take the same orders.
bool was_lawful_to(PeerId relayer, const Bundle& b, const View& view) {
  return relayer != kNoPeer && relayer != b.peer && view.roster.seats[relayer].there() &&
         view.roster.seats[relayer].since < b.tick;
}

/// Whether the incarnations that an update assigns, by itself or in what it passes on, are no further ahead of the
/// newest one than honest coordinators get. Without this limit one admission could use up the numbers of a session.
bool is_in_step(const Bundle& b, const View& view, std::uint32_t& newest) {
  if (view.log.knows(b.peer, b.index)) return true;
  if (b.admission) {
    if (b.admission->incarnation > newest + kMostIncarnationStep) return false;
    newest = std::max(newest, b.admission->incarnation);
  }
  return std::all_of(b.passed_on.begin(), b.passed_on.end(),
                     [&](const Bundle& lost) { return is_in_step(lost, view, newest); });
}

}  // namespace

// A signature takes far longer to check than to repeat.
bool MisbehaviourPolicy::may_check(const sync::StatePacket& packet, const View& view) {
  if (!session_.config.sealed || packet.updates.empty()) return true;
  int needed = 0;
  for (const Bundle& b : packet.updates) needed += signatures_in(b, view);
  return watch(packet.updates.front().peer, view).own.take(needed, view.roster.now);
}

DropReason MisbehaviourPolicy::judge(const sync::StatePacket& packet, PeerId relayed_by, const View& view,
                                     const Evictions& evictions) {
  for (const Bundle& b : packet.updates)  // what the log would not take needs no check
    if (b.index > view.log.have(b.peer) + sync::UpdateLog::kMostBeyond) return DropReason::kOrder;
  if (!may_check(packet, view)) return DropReason::kCutOff;
  const auto waiting = session_.config.sealed ? waiting_admissions(packet, view) : std::vector<Bundle>{};
  Admitted meanwhile;
  for (const Bundle& b : waiting) meanwhile.push_back(&*b.admission);
  PeerSet freed = 0;
  std::uint32_t newest = view.roster.newest_incarnation();
  for (const Bundle& b : packet.updates) {
    const bool lawful = is_lawful(b, view, evictions, freed, session_.config.sealed) ||
                        (session_.config.sealed && was_lawful_to(relayed_by, b, view));
    if (!lawful || !is_in_step(b, view, newest)) {
      if (b.index == view.log.have(b.peer)) watch(b.peer, view).refused = view.roster.now;
      return DropReason::kRight;
    }
    note_freed(b, freed);
    if (!session_.config.sealed) continue;
    if (b.admission && !b.admission->at.has_key()) return DropReason::kValue;
    const Signed is = is_signed(b, false, view, meanwhile);
    if (is != Signed::kYes) return is == Signed::kNo ? DropReason::kSignature : DropReason::kRight;
  }
  return DropReason::kNone;
}

bool MisbehaviourPolicy::said(PeerId by, const Bundle& b, const View& view) {
  const int needed = session_.config.sealed ? signatures_in(b, view) : 0;
  return watch(by, view).shown.take(needed, view.roster.now) && said(b, view);
}

bool MisbehaviourPolicy::said(const Bundle& b, const View& view) const {
  std::uint32_t newest = view.roster.newest_incarnation();
  if (!is_in_step(b, view, newest)) return false;
  if (!session_.config.sealed) return true;
  if (missing_signer(b, view, {})) return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(), [&](const Bundle& lost) { return said(lost, view); });
}

MisbehaviourPolicy::Watch& MisbehaviourPolicy::watch(PeerId p, const View& view) {
  Watch& w = watches_[p];
  if (w.incarnation != view.roster.seats[p].incarnation) {
    w = {};
    w.incarnation = view.roster.seats[p].incarnation;
  }
  return w;
}

bool MisbehaviourPolicy::hears(PeerId p, const View& view) const {
  const Seat& s = view.roster.seats[p];
  if (session_.config.sealed && bars(s.at.key, view)) return false;
  const Watch& w = watches_[p];
  return w.incarnation != s.incarnation || view.roster.now >= w.deaf_until;
}

void MisbehaviourPolicy::on_drop(PeerId p, DropReason why, const View& view, Micros local, Commands& out) {
  // Late datagrams of a removed peer, and duplicates by the network, are nobody's fault.
  if (!view.roster.seats[p].reachable() || why == DropReason::kForeign || why == DropReason::kDuplicate) return;
  Watch& w = watch(p, view);
  if (why == DropReason::kRight) w.unlawful = view.roster.now;
  tell(p, why, w, local, out);
  if (!session_.config.sealed) return;
  if (why == DropReason::kPromise)
    return cut_off(p, Ban::kEnds, "has sent an update of a time for which it had promised that there are no more", view,
                   out);
  if (!is_nonsense(why)) return;
  if (is_too_much(p, view)) cut_off(p, Ban::kForGood, "keeps sending invalid datagrams", view, out);
}

// Whether the first update of p that is missing here is an order that nobody has relayed.
bool MisbehaviourPolicy::is_refused(PeerId p, const View& view) {
  return session_.config.sealed && view.roster.now - watch(p, view).refused < kUnlawful && view.arrears(p) >= kRefused;
}

// What is dropped may be lawful by an order of somebody who has left, or was lost, before this peer got it. With a key
// another member, by whose word such an order counts, has sent it by now.
bool MisbehaviourPolicy::may_lack_an_order(PeerId p, const View& view) {
  if (session_.config.sealed || view.roster.now - watch(p, view).unlawful >= kUnlawful) return false;
  for (PeerId q = 0; q < view.roster.slots(); ++q)
    if (q != p && q != view.roster.self && view.roster.seats[q].there() && view.roster.silence(q) > kTicksPerSecond &&
        view.arrears(q) >= view.arrears(p))
      return true;
  return false;
}

bool MisbehaviourPolicy::is_too_much(PeerId p, const View& view) {
  const Tick now = view.roster.now;
  std::deque<Tick>& nonsense = offender(p, view).nonsense;
  nonsense.push_back(now);
  while (nonsense.front() < now - kWithin) nonsense.pop_front();
  return nonsense.size() >= kNonsense;
}

MisbehaviourPolicy::Offender& MisbehaviourPolicy::offender(PeerId p, const View& view) {
  const PublicKey& key = view.roster.seats[p].at.key;
  const auto it = std::find_if(offenders_.begin(), offenders_.end(), [&](const Offender& o) { return o.key == key; });
  if (it != offenders_.end()) return *it;
  // The entry with the longest ban is kept longest.
  if (offenders_.size() == kMostOffenders)
    offenders_.erase(std::min_element(offenders_.begin(), offenders_.end(), [](const Offender& a, const Offender& b) {
      return a.barred_until < b.barred_until;
    }));
  offenders_.emplace_back().key = key;
  return offenders_.back();
}

bool MisbehaviourPolicy::is_heard(PeerId p, const View& view) const {
  const Seat& s = view.roster.seats[p];
  return p != view.roster.self && s.there() && !s.frozen && view.roster.silence(p) <= kTicksPerSecond && hears(p, view);
}

void MisbehaviourPolicy::advance(const View& view, Commands& out) {
  if (!view.roster.member || view.roster.leaving) return;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!is_heard(p, view)) {
      watch(p, view).unheard = view.roster.now;
      continue;
    }
    const bool refused = is_refused(p, view);
    if (!refused && !view.delays(p)) continue;
    const bool tells = !refused && view.arrears(p) < View::kArrears;
    if (!tells && view.lacks_former(p)) continue;  // this peer has to join anew
    // Its updates may be on their way: a link that fails all the time has let nothing but marks through.
    const bool is_back = view.roster.now - watch(p, view).unheard < kBackFor;
    if (!tells && is_back && view.arrears(p) < kMostArrears) continue;
    // A lying coordinator can make an honest member freeze this peer for as long as it takes to see through it.
    const Tick patience = (view.returning & only(p)) != 0 ? kMostPatience : kPatience;  // barred, it could not return
    if (tells && view.roster.unacknowledged(p) < patience) continue;
    if (!tells && may_lack_an_order(p, view)) continue;  // this peer has to join anew
    const Tick lasted = tells ? patience : refused ? kRefused : View::kArrears;
    const std::string what = tells     ? "acknowledged no updates"
                             : refused ? "given orders that it has no right to give"
                                       : "not sent the updates that it promised";
    cut_off(p, refused ? Ban::kEnds : Ban::kAtFirst,
            "has " + what + " for " + std::to_string(lasted / kTicksPerSecond) + " s", view, out);
    if (session_.config.sealed) offender(p, view).pardonable = tells && offender(p, view).times == 0;
  }
}

void MisbehaviourPolicy::convict(PeerId p, const View& view, Commands& out) {
  const Seat& s = view.roster.seats[p];
  if (!session_.config.sealed) return;
  // This peer's former incarnation may have barred it.
  if (!bars_for_good(s.at.key)) cut_off(p, Ban::kForGood, "has signed two different updates of one number", view, out);
  if (!s.given_up_for_good) out.give_up(p, true);
}

void MisbehaviourPolicy::distrust(PeerId p, const View& view, Commands& out) {
  cut_off(p, Ban::kEnds, "has kept back an update that it promised was none", view, out);
}

// How long p is barred, ticks.
Tick MisbehaviourPolicy::bar(PeerId p, Ban ban, const View& view) {
  if (!session_.config.sealed) return kBarred;  // only a key identifies a peer
  Offender& o = offender(p, view);
  o.nonsense.clear();
  o.pardonable = false;
  if (ban == Ban::kForGood) {
    o.barred_until = kForGood;
    return kForGood;
  }
  constexpr int kMostDoubled = 6;
  const bool at_first = ban == Ban::kAtFirst && o.times == 0 && !std::exchange(o.warned, true);
  const Tick until = view.roster.now + (at_first ? kBarredAtFirst : kBarred << std::min(o.times, kMostDoubled));
  o.barred_until = std::max(o.barred_until, until);
  if (!at_first) ++o.times;
  return until - view.roster.now;
}

void MisbehaviourPolicy::inherit(const MisbehaviourPolicy& before, const PublicKey& let_in_by) {
  offenders_ = before.offenders_;
  for (Offender& o : offenders_)
    if (o.key == let_in_by && o.barred_until != kForGood) o.barred_until = 0;
}

void MisbehaviourPolicy::pardon(const PublicKey& key) {
  for (Offender& o : offenders_)
    if (o.key == key && std::exchange(o.pardonable, false)) o.barred_until = 0;
}

bool MisbehaviourPolicy::bars_for_good(const PublicKey& key) const {
  return std::any_of(offenders_.begin(), offenders_.end(),
                     [&](const Offender& o) { return o.key == key && o.barred_until == kForGood; });
}

Tick MisbehaviourPolicy::bars_for(const PublicKey& key, const View& view) const {
  for (const Offender& o : offenders_)
    if (o.key == key) return o.barred_until == kForGood ? kForGood : std::max(0, o.barred_until - view.roster.now);
  return 0;
}

void MisbehaviourPolicy::tell(PeerId p, DropReason why, Watch& w, Micros local, Commands& out) {
  Watch::Told& told = w.told[static_cast<std::size_t>(why)];
  ++told.drops;
  if (local - told.at < kTellAgain) return;
  out.tell({.kind = SessionEvent::Kind::kDropped,
            .peer = p,
            .count = told.drops,
            .text = std::string(sync::kDropNames[static_cast<std::size_t>(why)])});
  told = {0, local};
}

// Its updates come by relay from now on, as long as other members hear it. If nobody hears it, it is evicted.
void MisbehaviourPolicy::cut_off(PeerId p, Ban ban, const std::string& why, const View& view, Commands& out) {
  const bool for_good = ban == Ban::kForGood;
  const Tick barred = bar(p, ban, view);
  watch(p, view).deaf_until = for_good ? kForGood : view.roster.now + barred;
  out.tell({.kind = for_good ? SessionEvent::Kind::kCutOff : SessionEvent::Kind::kMuted,
            .peer = p,
            .tick = barred,
            .text = why});
  out.cut_off(p, why);
}

}  // namespace padr::node
