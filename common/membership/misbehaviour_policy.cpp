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
  kUnclear,  ///< not by the peer that we know; the admission of a newer one may be on its way
};

/// The peer that published the slot's update of that number; nothing if it is not known.
std::optional<Sayer> sayer(PeerId p, std::uint32_t index, const View& view, const Admitted& meanwhile) {
  for (auto a = meanwhile.rbegin(); a != meanwhile.rend(); ++a)
    if ((*a)->slot == p && index >= (*a)->first) return Sayer{(*a)->incarnation, (*a)->at.key};
  const Seat& n = view.roster.seats[p];
  if (index >= n.first && p != view.roster.self)
    return n.at.has_key() ? std::optional(Sayer{n.incarnation, n.at.key}) : std::nullopt;
  for (auto f = n.former.rbegin(); f != n.former.rend(); ++f)
    if (index >= f->first && f->at.has_key()) return Sayer{f->incarnation, f->at.key};
  return std::nullopt;
}

/// Reasons that no honest peer causes, and under a seal no network fault either.
bool is_nonsense(DropReason why) {
  return why == DropReason::kMalformed || why == DropReason::kEntity || why == DropReason::kValue ||
         why == DropReason::kTick || why == DropReason::kSignature;
}

/// Whether x may have been the coordinator at tick t: no lower peer is alive, as far as this peer can tell.
bool may_coordinate(PeerId x, Tick t, const View& view, const Evictions& evictions) {
  const auto new_then = [t](std::uint32_t incarnation, Tick since) {
    return incarnation > 0 && since + kHandOver >= t;
  };
  for (PeerId p = 0; p < x; ++p) {
    if (p == view.roster.self) {
      if (!view.roster.leaving && !new_then(view.roster.incarnation, view.roster.in_since)) return false;
      continue;
    }
    const Seat& n = view.roster.seats[p];
    const bool well = n.there() && !n.frozen && !Evictions::suspected(view, p) && !evictions.answered(x, p);
    if (well && !new_then(n.incarnation, n.since)) return false;
  }
  return true;
}

bool may_pass_on(const Bundle& lost, const Bundle& by, const View& view, const Evictions& evictions) {
  const Seat& n = view.roster.seats[lost.peer];
  // A known update changes nothing, and all of our own are known.
  if (view.log.knows(lost.peer, lost.index)) return true;
  if (lost.peer == view.roster.self) return lost.index < n.first;
  if (evictions.answered(by.peer, lost.peer)) return true;
  const bool of_nobody_now = lost.index < n.first || !n.there() || n.frozen;
  return of_nobody_now && may_coordinate(by.peer, by.tick, view, evictions);
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
         Evictions::suspected(view, lost) && may_coordinate(by.peer, by.tick, view, evictions);
}

/// Whether its peer may give this order. Updates that an order passes on are not judged again.
bool is_lawful(const Bundle& b, const View& view, const Evictions& evictions) {
  const bool order = b.admission || !b.removals.empty() || !b.passed_on.empty();
  if (!order || view.log.knows(b.peer, b.index)) return true;
  // For an order from before our admission, other members were polled.
  if (!view.roster.member || b.tick <= view.roster.in_since) return true;
  for (const sync::Removal& r : b.removals)
    if (!evictions.answered(b.peer, r.slot, r.incarnation) && !could_not_ask(b, r.slot, view, evictions)) return false;
  if (b.admission && !may_coordinate(b.peer, b.tick, view, evictions)) return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(),
                     [&](const Bundle& lost) { return may_pass_on(lost, b, view, evictions); });
}

/// The peer whose valid signature a new update lacks; nothing if it has one, or if the peer is not known.
std::optional<Sayer> missing_signer(const Bundle& b, const View& view, const Admitted& meanwhile) {
  if (view.log.knows(b.peer, b.index)) return std::nullopt;
  const auto who = sayer(b.peer, b.index, view, meanwhile);
  if (who && wire::is_signed(who->key, {view.roster.session, who->incarnation}, b)) return std::nullopt;
  return who;
}

/// Whether an update and those that it passes on are signed. `by`: the update that passes it on. Adds admissions to
/// `meanwhile`.
Signed is_signed(const Bundle& b, const Bundle* by, const View& view, const Evictions& evictions, Admitted& meanwhile) {
  if (const auto who = missing_signer(b, view, meanwhile)) {
    // A peer that passes on an update of a slot may know of a newer occupant that we have not heard of yet.
    const bool may_be_new = by != nullptr && !evictions.answered(by->peer, b.peer, who->incarnation);
    return may_be_new ? Signed::kUnclear : Signed::kNo;
  }
  if (b.admission) meanwhile.push_back(&*b.admission);
  for (const Bundle& lost : b.passed_on)
    if (const Signed is = is_signed(lost, &b, view, evictions, meanwhile); is != Signed::kYes) return is;
  return Signed::kYes;
}

}  // namespace

DropReason MisbehaviourPolicy::judge(const sync::StatePacket& packet, const View& view,
                                     const Evictions& evictions) const {
  Admitted meanwhile;
  for (const Bundle& b : packet.updates) {
    if (!is_lawful(b, view, evictions)) return DropReason::kRight;
    if (!session_.config.sealed) continue;
    if (b.admission && !b.admission->at.has_key()) return DropReason::kValue;
    const Signed is = is_signed(b, nullptr, view, evictions, meanwhile);
    if (is != Signed::kYes) return is == Signed::kNo ? DropReason::kSignature : DropReason::kRight;
  }
  return DropReason::kNone;
}

bool MisbehaviourPolicy::said(const Bundle& b, const View& view) const {
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
  const Watch& w = watches_[p];
  return w.incarnation != view.roster.seats[p].incarnation || view.roster.now >= w.deaf_until;
}

void MisbehaviourPolicy::on_drop(PeerId p, DropReason why, const View& view, const Evictions& evictions, Micros local,
                                 Commands& out) {
  // Late datagrams of a removed peer, and duplicates by the network, are nobody's fault.
  if (!view.roster.seats[p].reachable() || why == DropReason::kForeign || why == DropReason::kDuplicate) return;
  Watch& w = watch(p, view);
  tell(p, why, w, local, out);
  if (!session_.config.sealed || (why != DropReason::kRight && !is_nonsense(why))) return;
  if (is_too_much(p, why, view)) cut_off(p, w, "keeps sending invalid datagrams", view, evictions, out);
}

bool MisbehaviourPolicy::is_too_much(PeerId p, DropReason why, const View& view) {
  const Tick now = view.roster.now;
  if (why == DropReason::kRight) {
    Watch& w = watch(p, view);
    if (!w.unlawful || now - w.unlawful->last > kMuted) w.unlawful = Watch::Series{now, now};
    w.unlawful->last = now;
    return now - w.unlawful->since >= kInsists;
  }
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

void MisbehaviourPolicy::advance(const View& view, const Evictions& evictions, Commands& out) {
  if (!view.roster.member || view.roster.leaving) return;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    const Seat& other = view.roster.seats[p];
    if (p == view.roster.self || !other.there() || other.frozen || view.roster.silence(p) > kTicksPerSecond) continue;
    const bool tells = view.arrears(p) < kArrears;
    if (tells && view.roster.unacknowledged(p) < kArrears) continue;
    Watch& w = watch(p, view);
    const PeerId coordinator = evictions.coordinator(view);
    if (w.deaf_until == kForGood || (coordinator != view.roster.self && coordinator != p)) continue;
    const std::string what = tells ? "acknowledged no updates" : "not sent the updates that it promised";
    cut_off(p, w, "has " + what + " for " + std::to_string(kArrears / kTicksPerSecond) + " s", view, evictions, out);
  }
  for (const PeerId p : evictions.withholding(view))
    if (Watch& w = watch(p, view); w.deaf_until != kForGood)
      cut_off(p, w, "does not send its updates of a lost peer", view, evictions, out);
}

void MisbehaviourPolicy::bar(PeerId p, bool for_good, const View& view) {
  if (!session_.config.sealed) return;  // only a key identifies a peer
  Offender& o = offender(p, view);
  constexpr int kMostDoubled = 6;
  const Tick until = view.roster.now + (kBarred << std::min(o.times, kMostDoubled));
  o.barred_until = for_good ? kForGood : std::max(o.barred_until, until);
  o.nonsense.clear();
  ++o.times;
}

bool MisbehaviourPolicy::bars(const PublicKey& key, const View& view) const {
  return std::any_of(offenders_.begin(), offenders_.end(),
                     [&](const Offender& o) { return o.key == key && view.roster.now < o.barred_until; });
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
void MisbehaviourPolicy::cut_off(PeerId p, Watch& w, const std::string& why, const View& view,
                                 const Evictions& evictions, Commands& out) {
  const PeerId coordinator = evictions.coordinator(view);
  const bool for_good = coordinator == view.roster.self || coordinator == p;
  const auto withholding = evictions.withholding(view);
  const bool by_network = view.arrears(p) >= kArrears || view.roster.unacknowledged(p) >= kArrears ||
                          std::find(withholding.begin(), withholding.end(), p) != withholding.end();
  bar(p, !by_network, view);
  w.unlawful.reset();
  w.deaf_until = for_good ? kForGood : view.roster.now + kMuted;
  out.tell({.kind = for_good ? SessionEvent::Kind::kCutOff : SessionEvent::Kind::kMuted, .peer = p, .text = why});
  out.cut_off(p, for_good, why);
}

bool said(const sync::Transfer& transfer, std::uint16_t session) {
  struct Sitter {
    std::uint32_t first = 0;
    Sayer who;
  };
  std::vector<std::vector<Sitter>> seats(transfer.slots.size());
  for (std::size_t p = 0; p < seats.size(); ++p)
    seats[p].push_back({0, {transfer.state.members[p].incarnation, transfer.slots[p].at.key}});
  // The address is that of the latest peer in the slot; the transfer has no key of earlier ones.
  const auto note = [&](const Bundle& b) {
    if (!b.admission || b.admission->slot >= seats.size()) return;
    std::vector<Sitter>& s = seats[b.admission->slot];
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
    const auto sitter = std::find_if(s.rbegin(), s.rend(), [&b](const Sitter& at) { return b.index >= at.first; });
    return sitter == s.rend() || sitter->who.key == PublicKey{} ||
           wire::is_signed(sitter->who.key, {session, sitter->who.incarnation}, b);
  });
}

}  // namespace padr::node
