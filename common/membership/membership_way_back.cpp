// When a member has to join anew, by whom it does, and when it leaves its seat for that.
#include <algorithm>
#include <utility>

#include "common/membership/membership.h"
#include "common/session/session_objection.h"

namespace padr::node {
namespace {

/// The confirmed world may wait until a peer is evicted; only a longer wait means that this peer is stuck.
constexpr Tick kStuck = 12 * kTicksPerSecond;
/// Age of the confirmed world at which this peer is stuck though it confirms a tick now and then. The others may be far
/// ahead: once, such a peer took their orders for unlawful ones, and cut them off.
constexpr Tick kBehind = 2 * kStuck;
/// Time for which this peer tries to join anew by one member, ticks.
constexpr Tick kInVain = 10 * kTicksPerSecond;
/// Time for which that member then counts as silent, ticks.
constexpr Tick kGivenUp = 60 * kTicksPerSecond;
/// Time for which it is remembered who has let this peer in anew as their hashes differed, ticks: so often a
/// coordinator that tells a false hash can make this peer begin anew.
constexpr Tick kDiffered = 10 * 60 * kTicksPerSecond;
/// Time for which a peer that knows of no living member asks one place, ticks.
constexpr Tick kInTurn = 2 * kTicksPerSecond;
/// Time after which such a peer founds the session anew, ticks; and how much later each one does for every more senior
/// one that has left, too: it then finds that one, which others can join.
constexpr Tick kFoundsAnew = 10 * kTicksPerSecond;
constexpr Tick kAfterSenior = 5 * kTicksPerSecond;
constexpr Micros kTenth = kMicrosPerSecond / 10;

}  // namespace

void Membership::inherit(const Membership& before, const PublicKey& let_in_by) {
  take(before.testimony_.proofs());
  misbehaviour_.inherit(before.misbehaviour_, let_in_by);
  merge_.inherit(before.merge_, before.view(), roster().now);
  differed_ = before.differed_;
  differed_until_ = before.differed_until_;
  if (before.testimony_.misled_by()) return;
  for (const Seat& s : before.roster().seats) {
    if (!s.differs || !s.at.has_key() || s.at.key != let_in_by) continue;
    differed_ = let_in_by;
    differed_until_ = roster().now + kDiffered;
  }
}

PeerId Membership::lacks_former() const {
  const View view = this->view();
  for (PeerId p = 0; p < session_.slots; ++p)
    if (roster().seats[p].there() && view.lacks_former(p) && view.arrears(p) >= View::kArrears / 2) return p;
  return kNoPeer;
}

// Who is silent to this peer, or has been given up, is no reason: it is evicted, and then the others go on.
bool Membership::is_overtaken() const {
  if (roster().now - confirmed_at_ <= kStuck && lacks_former() == kNoPeer) return false;
  const View view = this->view();
  for (PeerId p = 0; p < session_.slots; ++p) {
    const Seat& s = roster().seats[p];
    if (s.there() && s.confirmed > confirmed_ && !Evictions::suspected(view, p)) return true;
  }
  return false;
}

// The others redirect whoever joins to the coordinator, which has to be another one. If all have cause to join anew,
// the last one stays until somebody whom it has let in is really there: a joiner may have given up just before.
void Membership::step_down() {
  if (roster().leaving ||
      (!testimony_.misled_by() && !evictions_.is_forsaken() && !evictions_.is_behind() && !is_overtaken()))
    return;
  const PeerId next = guide();
  stands_down_ = coordinator() == session_.self && next != kNoPeer && roster().seats[next].proven;
  if (!stands_down_) return;
  announce_way_back();
  replica_.leave();
}

PeerId Membership::guide() const {
  const auto liar = testimony_.misled_by();
  PeerSet unfit = only(session_.self) | (liar ? only(*liar) : 0);
  for (PeerId p = 0; p < session_.slots; ++p)
    if (!hears(p)) unfit |= only(p);
  return evictions_.first_of(view(), unfit);
}

void Membership::watch_confirmed() {
  const Tick confirmed = replica_.replica().agreed().confirmed().tick;
  if (confirmed != confirmed_) confirmed_at_ = roster().now;
  confirmed_ = confirmed;
  merge_.set_stalled(roster().now - confirmed_at_ >= PartitionMerge::kStalled);
}

// The coordinator's confirmed world is the right one, whatever other members say.
std::string Membership::why_back() const {
  const Replica& n = replica_.replica();
  if (const auto liar = testimony_.misled_by(); liar && guide() != kNoPeer)
    return "peer " + std::to_string(*liar) + " kept an update from this peer that it has told others";
  if (evictions_.is_forsaken() && guide() != kNoPeer) return "none of the others follows this peer";
  if (evictions_.is_behind() && guide() != kNoPeer)
    return "all others have an update of a lost peer that none of them can send";
  const PeerId c = coordinator();
  if (c == session_.self || c == kNoPeer) return "";
  if (const Micros lead = n.least_clock_lead(); lead >= Replica::kFarAhead)
    return "this peer's clock is " + in_seconds(lead - lead % kTenth) + " ahead of most others'";
  // With a key, the two first find out who has lied to whom.
  const Tick disputed = session_.config.sealed ? roster().now - n.seat(c).disputed : Testimony::kDispute;
  if (n.seat(c).differs && disputed >= Testimony::kDispute && !is_odd_one_out(c))
    return "CONFIRMED WORLDS DIFFER from peer " + std::to_string(c) + "'s at tick " +
           std::to_string(n.stats().first_mismatch);
  if (const PeerId p = lacks_former(); p != kNoPeer)
    return "a former peer " + std::to_string(p) + " kept an update from this peer that it has told others";
  if (roster().now - confirmed_at_ > kStuck)
    return "nothing has been confirmed for " + std::to_string(kStuck / kTicksPerSecond) + " s";
  if (roster().now - std::max(confirmed_, roster().in_since) > kBehind)
    return "what is confirmed is " + std::to_string(kBehind / kTicksPerSecond) + " s old";
  if (n.expelled()) return "the others have declared this peer gone";
  return roster().leaving && stands_down_ ? "it has left its seat to join anew" : "";
}

// A coordinator that lies can make all others join anew, and then let none of them in. Whoever is asked before the
// coordinator, as that one has lied, may first have to find out itself.
void Membership::give_up_guide() {
  const Tick now = roster().now;
  if (!is_alone()) alone_since_ = now;
  std::erase_if(in_vain_, [&](const auto& entry) {
    const auto& [slot, asked] = entry;
    // Others may have heard for a while who was silent here. Then that one is gone by now, or has told what was
    // missing.
    const bool cleared = asked.spared && confirmed_at_ > asked.since;
    return cleared || now - asked.since >= kGivenUp || roster().seats[slot].incarnation != asked.incarnation;
  });
  const bool returns = !why_back().empty();
  told_ = told_ && returns;
  const PeerId by = returns ? guide() : kNoPeer;
  if (std::exchange(asked_, by) != by) back_since_ = now;
  if (const PeerId c = coordinator(); std::exchange(coordinates_, c) != c) coordinates_since_ = now;
  if (!session_.config.sealed || (roster().leaving && !stands_down_) || by == kNoPeer) {
    back_since_ = now;
  } else if (const bool spares = spares_silent(by);
             spares || now - back_since_ >= (by == coordinator() ? kInVain : 2 * kInVain)) {
    in_vain_[by] = {roster().seats[by].incarnation, now, spares};
    evictions_.forget_asker(by);
    back_since_ = now;
  }
  for (const auto& [slot, asked] : in_vain_) commands_.give_up(slot, true);
}

// An honest coordinator asks about whoever is silent, and passes on the updates of whoever only it hears. One that has
// admitted somebody who is nowhere would let all in again, to where nothing is confirmed either.
bool Membership::spares_silent(PeerId c) const {
  if (c != coordinator() || roster().now - confirmed_at_ <= kStuck ||
      roster().now - coordinates_since_ < Evictions::kWithheld)
    return false;
  for (PeerId p = 0; p < session_.slots; ++p) {
    const Seat& s = roster().seats[p];
    if (p != session_.self && p != c && s.there() && !s.frozen && !evictions_.answered(c, p, s.incarnation) &&
        roster().unanswered(p) >= kSilence + Evictions::kWithheld)
      return true;
  }
  return false;
}

// Whoever has taken over a world confirms the same as the member that gave it. If the two differ again, and all others
// agree with this peer, that member tells a false hash.
bool Membership::is_odd_one_out(PeerId c) const {
  const Seat& odd = roster().seats[c];
  if (!odd.at.has_key() || odd.at.key != differed_ || roster().now >= differed_until_) return false;
  bool agrees = false;
  for (PeerId p = 0; p < session_.slots; ++p) {
    const Seat& s = roster().seats[p];
    if (p == session_.self || p == c || !s.there() || !hears(p)) continue;
    if (s.differs) return false;
    agrees |= s.same >= odd.differs_at;
  }
  return agrees;
}

std::optional<Endpoint> Membership::way_back() const {
  if (roster().leaving && !stands_down_) return std::nullopt;
  if (const auto winner = merge_.winner(view())) return winner;
  if (is_alone()) return place_of_somebody();
  const PeerId by = guide();
  if (by == kNoPeer || why_back().empty()) return std::nullopt;
  return roster().seats[by].at;
}

// They may all be members again, as others than this peer knows. It asks each for a while, in turn.
std::optional<Endpoint> Membership::place_of_somebody() const {
  const auto liar = testimony_.misled_by();
  std::vector<Endpoint> places;
  const auto add = [&](const Endpoint& at) {
    if (at.is_set() && !bars(at.key) && !(liar && roster().seats[*liar].at == at)) places.push_back(at);
  };
  for (PeerId p = 0; p < session_.slots; ++p)
    if (p != session_.self) add(roster().seats[p].at);
  for (const sync::Transfer::Gone& g : merge_.gone()) add(g.at);
  if (places.empty()) return std::nullopt;
  return places[static_cast<std::size_t>(roster().now / kInTurn) % places.size()];
}

// Several that have left one after the other may be all who live: nobody of them can let the others in.
bool Membership::founds_anew() const {
  Tick after = kFoundsAnew;
  for (PeerId p = 0; p < session_.slots; ++p)
    if (roster().seats[p].presence == Presence::kLeft && roster().is_senior(p, session_.self)) after += kAfterSenior;
  return roster().now - alone_since_ >= std::min(after, 2 * kFoundsAnew);
}

bool Membership::asks_in_vain(const Endpoint& at) const {
  return is_alone() || std::any_of(roster().seats.begin(), roster().seats.end(),
                                   [&](const Seat& s) { return s.presence == Presence::kLeft && s.at == at; });
}

void Membership::give_seat_back() {
  if (roster().leaving || why_back().empty()) return;
  stands_down_ = true;
  replica_.leave();
}

void Membership::announce_way_back() {
  const std::string why = why_back();
  if (!why.empty() && !std::exchange(told_, true))
    commands_.tell({.kind = SessionEvent::Kind::kReturning, .text = why});
}

}  // namespace padr::node
