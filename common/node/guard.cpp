#include "common/node/guard.h"

#include <algorithm>
#include <optional>
#include <string>

#include "common/node/removals.h"
#include "common/wire/signature.h"

namespace padr::node {
namespace {

using sync::Bundle;
using sync::DropReason;

/// A coordinator may still send orders that it was preparing when a lower peer came in.
constexpr Tick kHandOver = 10 * kTicksPerSecond;
constexpr Tick kForGood = std::numeric_limits<Tick>::max();

struct Sayer {
  std::uint32_t incarnation = 0;
  PublicKey key{};
};

/// Those that are in the datagram that is being judged, by order.
using Admissions = std::vector<const sync::Admission*>;

enum class Signed : std::uint8_t {
  kYes,
  kNo,
  kUnclear,  ///< not by whom we know, but the word of who sits there now may be on its way
};

/// Who sat in the slot when its update of that number was said; nothing if that is not known.
std::optional<Sayer> sayer(PeerId p, std::uint32_t index, const Node& node, const Admissions& meanwhile) {
  for (auto a = meanwhile.rbegin(); a != meanwhile.rend(); ++a)
    if ((*a)->slot == p && index >= (*a)->first) return Sayer{(*a)->incarnation, (*a)->at.key};
  const Neighbour& n = node.other(p);
  if (index >= n.first && p != node.self())
    return n.at.has_key() ? std::optional(Sayer{n.incarnation, n.at.key}) : std::nullopt;
  for (auto f = n.former.rbegin(); f != n.former.rend(); ++f)
    if (index >= f->first && f->at.has_key()) return Sayer{f->incarnation, f->at.key};
  return std::nullopt;
}

/// What is no honest peer's, ever, and no accident of the network's under a seal.
bool is_nonsense(DropReason why) {
  return why == DropReason::kMalformed || why == DropReason::kEntity || why == DropReason::kValue ||
         why == DropReason::kTick || why == DropReason::kSignature;
}

/// Whether x may have been the coordinator at tick t: nobody lower is there who is well as far as we can tell.
bool may_coordinate(PeerId x, Tick t, const Node& node, const Removals& removals) {
  const auto new_then = [t](std::uint32_t incarnation, Tick since) {
    return incarnation > 0 && since + kHandOver >= t;
  };
  for (PeerId p = 0; p < x; ++p) {
    if (p == node.self()) {
      if (!node.leaving() && !new_then(node.config().incarnation, node.in_since())) return false;
      continue;
    }
    const Neighbour& n = node.other(p);
    const bool well = n.there() && !n.frozen && !Removals::suspected(node, p) && !removals.answered(x, p);
    if (well && !new_then(n.incarnation, n.since)) return false;
  }
  return true;
}

bool may_pass_on(const Bundle& lost, const Bundle& by, const Node& node, const Removals& removals) {
  const Neighbour& n = node.other(lost.peer);
  // What we know already is nothing new, and what we have said we know.
  if (node.agreed().log().knows(lost.peer, lost.index)) return true;
  if (lost.peer == node.self()) return lost.index < n.first;
  if (removals.answered(by.peer, lost.peer)) return true;
  const bool of_nobody_now = lost.index < n.first || !n.there() || n.frozen;
  return of_nobody_now && may_coordinate(by.peer, by.tick, node, removals);
}

/// Whoever let us in may have been lost before the others had heard of us: then nobody could ask us what we have of it.
bool could_not_ask(const Bundle& by, PeerId lost, const Node& node, const Removals& removals) {
  return node.config().incarnation > 0 && by.tick <= node.in_since() + Removals::kWithheld &&
         Removals::suspected(node, lost) && may_coordinate(by.peer, by.tick, node, removals);
}

/// Whether its peer may give this order. What an order passes on was another's to give, and is not judged again.
bool is_lawful(const Bundle& b, const Node& node, const Removals& removals) {
  const bool order = b.admission || !b.removals.empty() || !b.passed_on.empty();
  if (!order || node.agreed().log().knows(b.peer, b.index)) return true;
  // Before we came, others were asked.
  if (!node.member() || b.tick <= node.in_since()) return true;
  for (const sync::Removal& r : b.removals)
    if (!removals.answered(b.peer, r.slot, r.incarnation) && !could_not_ask(b, r.slot, node, removals)) return false;
  if (b.admission && !may_coordinate(b.peer, b.tick, node, removals)) return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(),
                     [&](const Bundle& lost) { return may_pass_on(lost, b, node, removals); });
}

/// Who must have said an update that is not here yet, and has not signed it; nothing if that is well, as far as is
/// known.
std::optional<Sayer> missing_signer(const Bundle& b, const Node& node, const Admissions& meanwhile) {
  if (node.agreed().log().knows(b.peer, b.index)) return std::nullopt;
  const auto who = sayer(b.peer, b.index, node, meanwhile);
  if (who && wire::is_signed(who->key, {node.config().session, who->incarnation}, b)) return std::nullopt;
  return who;
}

/// Of an update and of what it passes on; `by`: what passes it on. Admissions are added to `meanwhile`.
Signed is_signed(const Bundle& b, const Bundle* by, const Node& node, const Removals& removals, Admissions& meanwhile) {
  if (const auto who = missing_signer(b, node, meanwhile)) {
    // Who passes on what has been said in a slot may know of somebody there of whom we have not heard yet.
    const bool may_be_new = by != nullptr && !removals.answered(by->peer, b.peer, who->incarnation);
    return may_be_new ? Signed::kUnclear : Signed::kNo;
  }
  if (b.admission) meanwhile.push_back(&*b.admission);
  for (const Bundle& lost : b.passed_on)
    if (const Signed is = is_signed(lost, &b, node, removals, meanwhile); is != Signed::kYes) return is;
  return Signed::kYes;
}

}  // namespace

DropReason Guard::judge(const sync::StatePacket& packet, const Node& node, const Removals& removals) const {
  Admissions meanwhile;
  for (const Bundle& b : packet.updates) {
    if (!is_lawful(b, node, removals)) return DropReason::kRight;
    if (!desk_.config.sealed) continue;
    if (b.admission && !b.admission->at.has_key()) return DropReason::kValue;
    const Signed is = is_signed(b, nullptr, node, removals, meanwhile);
    if (is != Signed::kYes) return is == Signed::kNo ? DropReason::kSignature : DropReason::kRight;
  }
  return DropReason::kNone;
}

bool Guard::said(const Bundle& b, const Node& node) const {
  if (!desk_.config.sealed) return true;
  if (missing_signer(b, node, {})) return false;
  return std::all_of(b.passed_on.begin(), b.passed_on.end(), [&](const Bundle& lost) { return said(lost, node); });
}

Guard::Watch& Guard::watch(PeerId p, const Node& node) {
  Watch& w = watches_[p];
  if (w.incarnation != node.other(p).incarnation) {
    w = {};
    w.incarnation = node.other(p).incarnation;
  }
  return w;
}

bool Guard::hears(PeerId p, const Node& node) const {
  const Watch& w = watches_[p];
  return w.incarnation != node.other(p).incarnation || node.now() >= w.deaf_until;
}

void Guard::on_drop(PeerId p, DropReason why, RecordedNode& node, const Removals& removals, Micros local) {
  const Node& n = node.node();
  // Late words of somebody who is out, and what the network says twice, are nobody's fault.
  if (!n.other(p).reachable() || why == DropReason::kForeign || why == DropReason::kDuplicate) return;
  Watch& w = watch(p, n);
  tell(p, why, w, local);
  if (!desk_.config.sealed || (why != DropReason::kRight && !is_nonsense(why))) return;
  if (is_too_much(p, why, n)) cut_off(p, w, "keeps sending invalid datagrams", node, removals);
}

bool Guard::is_too_much(PeerId p, DropReason why, const Node& node) {
  const Tick now = node.now();
  if (why == DropReason::kRight) {
    Watch& w = watch(p, node);
    if (!w.unlawful || now - w.unlawful->last > kMuted) w.unlawful = Watch::Series{now, now};
    w.unlawful->last = now;
    return now - w.unlawful->since >= kInsists;
  }
  std::deque<Tick>& nonsense = offender(p, node).nonsense;
  nonsense.push_back(now);
  while (nonsense.front() < now - kWithin) nonsense.pop_front();
  return nonsense.size() >= kNonsense;
}

Guard::Offender& Guard::offender(PeerId p, const Node& node) {
  const PublicKey& key = node.other(p).at.key;
  const auto it = std::find_if(offenders_.begin(), offenders_.end(), [&](const Offender& o) { return o.key == key; });
  if (it != offenders_.end()) return *it;
  // Who is barred for the longest is remembered the longest.
  if (offenders_.size() == kMostOffenders)
    offenders_.erase(std::min_element(offenders_.begin(), offenders_.end(), [](const Offender& a, const Offender& b) {
      return a.barred_until < b.barred_until;
    }));
  offenders_.emplace_back().key = key;
  return offenders_.back();
}

void Guard::advance(RecordedNode& node, const Removals& removals) {
  const Node& n = node.node();
  if (!n.member() || n.leaving()) return;
  for (PeerId p = 0; p < n.config().slots; ++p) {
    const Neighbour& other = n.other(p);
    if (p == n.self() || !other.there() || other.frozen || n.silence(p) > kTicksPerSecond) continue;
    const bool tells = n.arrears(p) < kArrears;
    if (tells && n.unacknowledged(p) < kArrears) continue;
    Watch& w = watch(p, n);
    const PeerId coordinator = removals.coordinator(n);
    if (w.deaf_until == kForGood || (coordinator != n.self() && coordinator != p)) continue;
    const std::string what = tells ? "acknowledged no updates" : "not sent the updates that it promised";
    cut_off(p, w, "has " + what + " for " + std::to_string(kArrears / kTicksPerSecond) + " s", node, removals);
  }
  for (const PeerId p : removals.withholding(n))
    if (Watch& w = watch(p, n); w.deaf_until != kForGood)
      cut_off(p, w, "does not send its updates of a lost peer", node, removals);
}

void Guard::bar(PeerId p, bool for_good, const Node& node) {
  if (!desk_.config.sealed) return;  // nothing else says who somebody is
  Offender& o = offender(p, node);
  constexpr int kMostDoubled = 6;
  const Tick until = node.now() + (kBarred << std::min(o.times, kMostDoubled));
  o.barred_until = for_good ? kForGood : std::max(o.barred_until, until);
  o.nonsense.clear();
  ++o.times;
}

bool Guard::bars(const PublicKey& key, const Node& node) const {
  return std::any_of(offenders_.begin(), offenders_.end(),
                     [&](const Offender& o) { return o.key == key && node.now() < o.barred_until; });
}

void Guard::tell(PeerId p, DropReason why, Watch& w, Micros local) {
  Watch::Told& told = w.told[static_cast<std::size_t>(why)];
  ++told.drops;
  if (local - told.at < kTellAgain) return;
  desk_.note("dropped " + std::to_string(told.drops) + (told.drops == 1 ? " datagram" : " datagrams") + " of peer " +
                 std::to_string(p) + ": " + std::string(sync::kDropNames[static_cast<std::size_t>(why)]),
             true);
  told = {0, local};
}

// The coordinator can have it removed, and whoever is next can if it is the coordinator itself. Anybody else who gave
// up on somebody whom the coordinator goes on hearing would wait for its updates for ever; so it only gets some rest.
void Guard::cut_off(PeerId p, Watch& w, const std::string& why, RecordedNode& node, const Removals& removals) {
  const Node& n = node.node();
  const PeerId coordinator = removals.coordinator(n);
  const bool for_good = coordinator == n.self() || coordinator == p;
  const auto withholding = removals.withholding(n);
  const bool by_network = n.arrears(p) >= kArrears || n.unacknowledged(p) >= kArrears ||
                          std::find(withholding.begin(), withholding.end(), p) != withholding.end();
  bar(p, !by_network, n);
  w.unlawful.reset();
  w.deaf_until = for_good ? kForGood : n.now() + kMuted;
  desk_.note("peer " + std::to_string(p) + " " + why + ": " +
                 (for_good ? "cut off" : "ignored for " + std::to_string(kMuted / kTicksPerSecond) + " s"),
             true);
  node.cut_off(p, for_good, why);
}

bool said(const sync::Transfer& transfer, std::uint16_t session) {
  struct Seat {
    std::uint32_t first = 0;
    Sayer who;
  };
  std::vector<std::vector<Seat>> seats(transfer.slots.size());
  for (std::size_t p = 0; p < seats.size(); ++p)
    seats[p].push_back({0, {transfer.state.members[p].incarnation, transfer.slots[p].at.key}});
  // Then the address is of who came last; of who was there before no key is told.
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
