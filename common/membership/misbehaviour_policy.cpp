#include "common/membership/misbehaviour_policy.h"

#include <algorithm>
#include <optional>
#include <string>

#include "common/membership/evictions.h"
#include "common/wire/signature.h"

namespace padr::node {
namespace {

using sync::Bundle;
using sync::DropReason;

/// Time for which a former coordinator may still send orders that it prepared before a lower peer was admitted.
constexpr Tick kHandOver = 10 * kTicksPerSecond;
constexpr Tick kForGood = std::numeric_limits<Tick>::max();

struct Sayer {
  std::uint32_t incarnation = 0;
  PublicKey key{};
};

/// Peers admitted earlier in the datagram that is being judged, in order.
using Admitted = std::vector<const sync::Admission*>;

enum class Signed : std::uint8_t {
  kYes,
  kNo,
  kUnclear,  ///< not by whom we know, but the word of who sits there now may be on its way
};

/// The peer that published the slot's update of that number; nothing if it is not known.
std::optional<Sayer> sayer(PeerId p, std::uint32_t index, const Replica& replica, const Admitted& meanwhile) {
  for (auto a = meanwhile.rbegin(); a != meanwhile.rend(); ++a)
    if ((*a)->slot == p && index >= (*a)->first) return Sayer{(*a)->incarnation, (*a)->at.key};
  const Neighbour& n = replica.other(p);
  if (index >= n.first && p != replica.self())
    return n.at.has_key() ? std::optional(Sayer{n.incarnation, n.at.key}) : std::nullopt;
  for (auto f = n.former.rbegin(); f != n.former.rend(); ++f)
    if (index >= f->first && f->at.has_key()) return Sayer{f->incarnation, f->at.key};
  return std::nullopt;
}

/// Reasons that no honest peer causes, and under a seal no accident of the network either.
bool is_nonsense(DropReason why) {
  return why == DropReason::kMalformed || why == DropReason::kEntity || why == DropReason::kValue ||
         why == DropReason::kTick || why == DropReason::kSignature;
}

/// Whether x may have been the coordinator at tick t: no lower peer is alive, as far as this peer can tell.
bool may_coordinate(PeerId x, Tick t, const Replica& replica, const Evictions& evictions) {
  const auto new_then = [t](std::uint32_t incarnation, Tick since) {
    return incarnation > 0 && since + kHandOver >= t;
  };
  for (PeerId p = 0; p < x; ++p) {
    if (p == replica.self()) {
      if (!replica.leaving() && !new_then(replica.config().incarnation, replica.in_since())) return false;
      continue;
    }
    const Neighbour& n = replica.other(p);
    const bool well = n.there() && !n.frozen && !Evictions::suspected(replica, p) && !evictions.answered(x, p);
    if (well && !new_then(n.incarnation, n.since)) return false;
  }
  return true;
}

bool may_pass_on(const Bundle& lost, const Bundle& by, const Replica& replica, const Evictions& evictions) {
  const Neighbour& n = replica.other(lost.peer);
  // An update that is here already tells nothing new, and our own are all here.
  if (replica.agreed().log().knows(lost.peer, lost.index)) return true;
  if (lost.peer == replica.self()) return lost.index < n.first;
  if (evictions.answered(by.peer, lost.peer)) return true;
  const bool of_nobody_now = lost.index < n.first || !n.there() || n.frozen;
  return of_nobody_now && may_coordinate(by.peer, by.tick, replica, evictions);
}

bool admitter_is_lost(const Bundle& by, const Replica& replica) {
  const PeerId admitter = replica.admitted_by();
  if (admitter == kNoPeer) return false;
  const Neighbour& n = replica.other(admitter);
  return !n.there() || n.since > replica.in_since() ||
         std::any_of(by.removals.begin(), by.removals.end(),
                     [admitter](const sync::Removal& r) { return r.slot == admitter; });
}

/// The peer that admitted us may have been lost before the others heard of us. Then nobody could ask us for its
/// updates, nor for those of who was lost with it.
bool could_not_ask(const Bundle& by, PeerId lost, const Replica& replica, const Evictions& evictions) {
  return by.tick <= replica.in_since() + Evictions::kWithheld && admitter_is_lost(by, replica) &&
         Evictions::suspected(replica, lost) && may_coordinate(by.peer, by.tick, replica, evictions);
}

/// Whether its peer may give this order. Updates that an order passes on are not judged again.
bool is_lawful(const Bundle& b, const Replica& replica, const Evictions& evictions) {
  const bool order = b.admission || !b.removals.empty() || !b.passed_on.empty();
  if (!order || replica.agreed().log().knows(b.peer, b.index)) return true;
  // Before we joined, others were asked.
  if (!replica.member() || b.tick <= replica.in_since()) return true;
  for (const sync::Removal& r : b.removals)
    if (!evictions.answered(b.peer, r.slot, r.incarnation) && !could_not_ask(b, r.slot, replica, evictions))
      return false;
  if (b.admission && !may_coordinate(b.peer, b.tick, replica, evictions)) return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(),
                     [&](const Bundle& lost) { return may_pass_on(lost, b, replica, evictions); });
}

/// The peer whose valid signature a new update lacks; nothing if it has one, or if the peer is not known.
std::optional<Sayer> missing_signer(const Bundle& b, const Replica& replica, const Admitted& meanwhile) {
  if (replica.agreed().log().knows(b.peer, b.index)) return std::nullopt;
  const auto who = sayer(b.peer, b.index, replica, meanwhile);
  if (who && wire::is_signed(who->key, {replica.config().session, who->incarnation}, b)) return std::nullopt;
  return who;
}

/// Of an update and of what it passes on; `by`: what passes it on. Admitted are added to `meanwhile`.
Signed is_signed(const Bundle& b, const Bundle* by, const Replica& replica, const Evictions& evictions,
                 Admitted& meanwhile) {
  if (const auto who = missing_signer(b, replica, meanwhile)) {
    // Who passes on what has been said in a slot may know of somebody there of whom we have not heard yet.
    const bool may_be_new = by != nullptr && !evictions.answered(by->peer, b.peer, who->incarnation);
    return may_be_new ? Signed::kUnclear : Signed::kNo;
  }
  if (b.admission) meanwhile.push_back(&*b.admission);
  for (const Bundle& lost : b.passed_on)
    if (const Signed is = is_signed(lost, &b, replica, evictions, meanwhile); is != Signed::kYes) return is;
  return Signed::kYes;
}

}  // namespace

DropReason MisbehaviourPolicy::judge(const sync::StatePacket& packet, const Replica& replica,
                                     const Evictions& evictions) const {
  Admitted meanwhile;
  for (const Bundle& b : packet.updates) {
    if (!is_lawful(b, replica, evictions)) return DropReason::kRight;
    if (!session_.config.sealed) continue;
    if (b.admission && !b.admission->at.has_key()) return DropReason::kValue;
    const Signed is = is_signed(b, nullptr, replica, evictions, meanwhile);
    if (is != Signed::kYes) return is == Signed::kNo ? DropReason::kSignature : DropReason::kRight;
  }
  return DropReason::kNone;
}

bool MisbehaviourPolicy::said(const Bundle& b, const Replica& replica) const {
  if (!session_.config.sealed) return true;
  if (missing_signer(b, replica, {})) return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(), [&](const Bundle& lost) { return said(lost, replica); });
}

MisbehaviourPolicy::Watch& MisbehaviourPolicy::watch(PeerId p, const Replica& replica) {
  Watch& w = watches_[p];
  if (w.incarnation != replica.other(p).incarnation) {
    w = {};
    w.incarnation = replica.other(p).incarnation;
  }
  return w;
}

bool MisbehaviourPolicy::hears(PeerId p, const Replica& replica) const {
  const Watch& w = watches_[p];
  return w.incarnation != replica.other(p).incarnation || replica.now() >= w.deaf_until;
}

void MisbehaviourPolicy::on_drop(PeerId p, DropReason why, const Replica& replica, const Evictions& evictions,
                                 Micros local, Commands& out) {
  // Late datagrams of a removed peer, and duplicates by the network, are nobody's fault.
  if (!replica.other(p).reachable() || why == DropReason::kForeign || why == DropReason::kDuplicate) return;
  Watch& w = watch(p, replica);
  tell(p, why, w, local, out);
  if (!session_.config.sealed || (why != DropReason::kRight && !is_nonsense(why))) return;
  if (is_too_much(p, why, replica)) cut_off(p, w, "keeps sending invalid datagrams", replica, evictions, out);
}

bool MisbehaviourPolicy::is_too_much(PeerId p, DropReason why, const Replica& replica) {
  const Tick now = replica.now();
  if (why == DropReason::kRight) {
    Watch& w = watch(p, replica);
    if (!w.unlawful || now - w.unlawful->last > kMuted) w.unlawful = Watch::Series{now, now};
    w.unlawful->last = now;
    return now - w.unlawful->since >= kInsists;
  }
  std::deque<Tick>& nonsense = offender(p, replica).nonsense;
  nonsense.push_back(now);
  while (nonsense.front() < now - kWithin) nonsense.pop_front();
  return nonsense.size() >= kNonsense;
}

MisbehaviourPolicy::Offender& MisbehaviourPolicy::offender(PeerId p, const Replica& replica) {
  const PublicKey& key = replica.other(p).at.key;
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

void MisbehaviourPolicy::advance(const Replica& replica, const Evictions& evictions, Commands& out) {
  if (!replica.member() || replica.leaving()) return;
  for (PeerId p = 0; p < replica.config().slots; ++p) {
    const Neighbour& other = replica.other(p);
    if (p == replica.self() || !other.there() || other.frozen || replica.silence(p) > kTicksPerSecond) continue;
    const bool tells = replica.arrears(p) < kArrears;
    if (tells && replica.unacknowledged(p) < kArrears) continue;
    Watch& w = watch(p, replica);
    const PeerId coordinator = evictions.coordinator(replica);
    if (w.deaf_until == kForGood || (coordinator != replica.self() && coordinator != p)) continue;
    const std::string what = tells ? "acknowledged no updates" : "not sent the updates that it promised";
    cut_off(p, w, "has " + what + " for " + std::to_string(kArrears / kTicksPerSecond) + " s", replica, evictions, out);
  }
  for (const PeerId p : evictions.withholding(replica))
    if (Watch& w = watch(p, replica); w.deaf_until != kForGood)
      cut_off(p, w, "does not send its updates of a lost peer", replica, evictions, out);
}

void MisbehaviourPolicy::bar(PeerId p, bool for_good, const Replica& replica) {
  if (!session_.config.sealed) return;  // nothing else says who somebody is
  Offender& o = offender(p, replica);
  constexpr int kMostDoubled = 6;
  const Tick until = replica.now() + (kBarred << std::min(o.times, kMostDoubled));
  o.barred_until = for_good ? kForGood : std::max(o.barred_until, until);
  o.nonsense.clear();
  ++o.times;
}

bool MisbehaviourPolicy::bars(const PublicKey& key, const Replica& replica) const {
  return std::any_of(offenders_.begin(), offenders_.end(),
                     [&](const Offender& o) { return o.key == key && replica.now() < o.barred_until; });
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

// The coordinator can evict the peer; if the peer is the coordinator, the next one can. Any other member that gave it
// up would wait for its updates for ever, as the coordinator still hears it. So another member only mutes it for a
// while.
void MisbehaviourPolicy::cut_off(PeerId p, Watch& w, const std::string& why, const Replica& replica,
                                 const Evictions& evictions, Commands& out) {
  const PeerId coordinator = evictions.coordinator(replica);
  const bool for_good = coordinator == replica.self() || coordinator == p;
  const auto withholding = evictions.withholding(replica);
  const bool by_network = replica.arrears(p) >= kArrears || replica.unacknowledged(p) >= kArrears ||
                          std::find(withholding.begin(), withholding.end(), p) != withholding.end();
  bar(p, !by_network, replica);
  w.unlawful.reset();
  w.deaf_until = for_good ? kForGood : replica.now() + kMuted;
  out.tell({.kind = for_good ? SessionEvent::Kind::kCutOff : SessionEvent::Kind::kMuted, .peer = p, .text = why});
  out.cut_off(p, for_good, why);
}

bool said(const sync::Transfer& transfer, std::uint16_t session) {
  struct Seat {
    std::uint32_t first = 0;
    Sayer who;
  };
  std::vector<std::vector<Seat>> seats(transfer.slots.size());
  for (std::size_t p = 0; p < seats.size(); ++p)
    seats[p].push_back({0, {transfer.state.members[p].incarnation, transfer.slots[p].at.key}});
  // The address is that of the latest peer in the slot; the transfer has no key of earlier ones.
  const auto note = [&](const Bundle& b) {
    if (!b.admission || b.admission->slot >= seats.size()) return;
    std::vector<Seat>& s = seats[b.admission->slot];
    if (b.admission->incarnation <= s.back().who.incarnation) return;
    s.front().who.key = {};
    s.push_back({b.admission->first, {b.admission->incarnation, b.admission->at.key}});
  };
  for (const Bundle& b : transfer.tail) {
    note(b);
    for (const Bundle& lost : b.passed_on) note(lost);
  }
  return std::all_of(transfer.tail.begin(), transfer.tail.end(), [&](const Bundle& b) {
    const auto& s = seats[b.peer];
    const auto seat = std::find_if(s.rbegin(), s.rend(), [&b](const Seat& at) { return b.index >= at.first; });
    return seat == s.rend() || seat->who.key == PublicKey{} ||
           wire::is_signed(seat->who.key, {session, seat->who.incarnation}, b);
  });
}

}  // namespace padr::node
