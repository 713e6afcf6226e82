#include "common/membership/admissions.h"

#include <algorithm>

#include "common/session/session_objection.h"
#include "common/sync/validation.h"
#include "common/wire/secret.h"
#include "common/wire/transfer_codec.h"

namespace padr::node {
namespace {

/// Time for which a transfer is kept for a joiner; a joiner takes well under a second.
constexpr Micros kStay = 8 * kMicrosPerSecond;
/// Most pieces in reply to one Pull.
constexpr int kBurst = 64;
constexpr std::uint64_t kSpread = 127;
/// Silence of a peer after which its slot may come free.
constexpr Tick kMayBeGone = kTicksPerSecond;

/// Whether the two are of one peer. A member may have said where a joiner is that has proven another address since: it
/// is known by its key.
bool is_same_peer(const Endpoint& at, const Endpoint& where) {
  return where.has_key() ? at.key == where.key : at == where;
}

}  // namespace

Admissions::Guest* Admissions::guest_at(const Endpoint& where, std::uint64_t nonce) {
  const auto it = std::find_if(guests_.begin(), guests_.end(),
                               [&](const Guest& g) { return is_same_peer(g.at, where) && g.nonce == nonce; });
  if (it == guests_.end()) return nullptr;
  it->at = where;
  return &*it;
}

// Not 0.
std::uint64_t Admissions::cookie_for(const Endpoint& where, std::uint64_t nonce) const {
  wire::Key key{};
  for (unsigned i = 0; i < 8; ++i) key[i] = static_cast<std::uint8_t>(session_.config.secret >> (8 * i));
  wire::Bytes text;
  for (const std::uint8_t b : where.address) text.push_back(static_cast<std::byte>(b));
  for (unsigned i = 0; i < 16; i += 8) text.push_back(static_cast<std::byte>(where.port >> i));
  for (unsigned i = 0; i < 64; i += 8) text.push_back(static_cast<std::byte>(nonce >> i));
  const wire::Tag tag = wire::tag_of(key, text);
  std::uint64_t cookie = 0;
  for (unsigned i = 0; i < 8; ++i) cookie |= std::to_integer<std::uint64_t>(tag[i]) << (8 * i);
  return std::max<std::uint64_t>(cookie, 1);
}

void Admissions::refuse(const Endpoint& from, const wire::Join& join, const std::string& reason, Commands& out) {
  out.send(from, wire::Refuse{join.nonce, reason});
  out.tell({.kind = SessionEvent::Kind::kRefused, .at = from, .text = reason});
}

void Admissions::on_join(const Endpoint& from, const wire::Join& join, const View& view, Micros local, Commands& out) {
  if (!out.may_answer(local)) return;
  Guest* guest = guest_at(from, join.nonce);
  if (guest == nullptr) {
    const std::string reason = objection(session_.config, join);
    if (!reason.empty()) return refuse(from, join, reason, out);
    guest = take_in(from, join, view, local, out);
    if (guest == nullptr) return;
  }
  wire::Welcome w;
  w.nonce = join.nonce;
  w.peer = guest->slot;
  w.slots = session_.slots;
  w.wanted = session_.wanted;
  w.incarnation = guest->incarnation;
  w.cookie = guest->cookie;
  w.session = session_.id;
  out.send(from, w);
}

Admissions::Guest* Admissions::take_in(const Endpoint& from, const wire::Join& join, const View& view, Micros local,
                                       Commands& out) {
  std::size_t sent = 0;
  std::size_t most = 0;
  Micros counted = local;
  std::erase_if(guests_, [&](const Guest& g) {  // restarted
    if (!same_place(g.at, from) || g.ordered) return false;
    if (local - g.counted <= kStay) sent = g.sent, most = g.most, counted = g.counted;
    return true;
  });
  const auto slot = free_slot(from, view);
  if (!slot) {
    const bool has_one = std::any_of(view.roster.seats.begin(), view.roster.seats.end(),
                                     [&](const Seat& s) { return s.there() && is_same_peer(s.at, from); });
    if (has_one || !may_come_free(view))
      refuse(from, join,
             std::string(kFull) + ": " + std::to_string(session_.slots) + " of " + std::to_string(session_.slots) +
                 " slots are taken",
             out);
    return nullptr;
  }
  Guest g;
  g.at = from;
  g.nonce = join.nonce;
  g.cookie = cookie_for(from, join.nonce);
  g.slot = *slot;
  g.since = local;
  g.sent = sent;
  g.most = most;
  g.counted = counted;
  g.spectator = join.spectator;
  g.incarnation = incarnation_for(join.nonce, view);
  if (g.incarnation >= sync::kEndOfNumbers) {
    refuse(from, join, "this session has had too many members; found another", out);
    return nullptr;
  }
  guests_.push_back(std::move(g));
  return &guests_.back();
}

// Never another peer's incarnation: late datagrams identify their sender and receiver by it. The step is drawn from the
// nonce: the other part of a partition hardly ever assigns the same incarnation. Joiners that come and go must not push
// the numbers beyond what members accept.
std::uint32_t Admissions::incarnation_for(std::uint64_t nonce, const View& view) const {
  const std::uint32_t newest = view.roster.newest_incarnation();
  std::uint32_t base = newest;
  for (const Guest& g : guests_)
    if (g.incarnation <= newest + kMostIncarnationStep / 4) base = std::max(base, g.incarnation);
  std::uint32_t next = base + 1 + static_cast<std::uint32_t>(nonce % kSpread);
  const auto is_taken = [&] {
    return std::any_of(guests_.begin(), guests_.end(), [&](const Guest& g) { return g.incarnation == next; });
  };
  while (is_taken()) ++next;
  return next;
}

// Whoever has left to join anew goes on sending until it is in.
bool Admissions::is_free(PeerId p, const Endpoint& joiner, const View& view) const {
  const sync::UpdateLog& log = view.log;
  const Seat& s = view.roster.seats[p];
  const bool empty = !s.reachable() || view.roster.departed(p) || (!s.there() && is_same_peer(s.at, joiner));
  return p != session_.self && empty && log.closed(p) && !log.waits(p);
}

// Its own only if there is no other: that one's last words may still be under way.
std::optional<PeerId> Admissions::free_slot(const Endpoint& joiner, const View& view) const {
  for (const Endpoint& owner : {Endpoint{}, joiner}) {
    for (PeerId p = 0; p < session_.slots; ++p) {
      const bool promised = std::any_of(guests_.begin(), guests_.end(), [p](const Guest& g) { return g.slot == p; });
      if (is_free(p, owner, view) && !promised) return p;
    }
  }
  return std::nullopt;
}

// A former coordinator that left may have admitted a joiner by an order that is not here yet.
bool Admissions::knows_all_orders(const View& view) const {
  const sync::UpdateLog& log = view.log;
  for (PeerId p = 0; p < session_.slots; ++p)
    if (p != session_.self && log.closed(p) && log.waits(p)) return false;
  return true;
}

bool Admissions::may_come_free(const View& view) const {
  if (std::any_of(guests_.begin(), guests_.end(), [](const Guest& g) { return !g.ordered; })) return true;
  for (PeerId p = 0; p < session_.slots; ++p) {
    const Seat& n = view.roster.seats[p];
    if (p != session_.self && (!n.there() || view.roster.unanswered(p) > kMayBeGone)) return true;
  }
  return false;
}

void Admissions::on_ping(const Endpoint& from, const wire::Ping& ping, Micros local, Commands& out) {
  const bool known =
      std::any_of(guests_.begin(), guests_.end(), [&](const Guest& g) { return is_same_peer(g.at, from); });
  if (known) out.send(from, wire::Pong{ping.sent, session_.clock.now(local)});
}

void Admissions::on_pull(const Endpoint& from, const wire::Pull& pull, const TransferSource& world, Micros local,
                         Commands& out) {
  Guest* guest = guest_at(from, pull.nonce);
  // All pieces together are many times as long as a Pull: an address that is not proven gets none.
  if (guest == nullptr || pull.cookie != guest->cookie) return;
  guest->proven = true;
  if (guest->pieces.empty()) {
    guest->since = local;  // a joiner that waits is not forgotten
    const auto coming_in = [&](const Guest& g) { return !g.pieces.empty() && !g.ordered && local - g.since < kTurn; };
    if (std::count_if(guests_.begin(), guests_.end(), coming_in) >= kAtOnce) return;
    const sync::Transfer t = world();
    const wire::Bytes all = wire::encode_transfer(t);
    guest->have = t.have;
    for (std::size_t at = 0; at < all.size(); at += wire::kPieceBytes) {
      const std::size_t n = std::min(wire::kPieceBytes, all.size() - at);
      guest->pieces.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                                 all.begin() + static_cast<std::ptrdiff_t>(at + n));
    }
  }
  const auto count = static_cast<std::uint32_t>(guest->pieces.size());
  guest->most = std::max<std::size_t>(guest->most, count);
  for (std::uint32_t i = 0; i < kBurst && pull.from + i < count; ++i) {
    if ((pull.wanted >> i & 1U) == 0 || guest->sent >= kMostTimes * guest->most) continue;
    ++guest->sent;
    out.send(from, wire::Piece{pull.nonce, pull.from + i, count, guest->pieces[pull.from + i]});
  }
}

// A peer that was removed, or left, after the joiner got its transfer sends the joiner nothing, and the members had no
// reason to publish updates that all of them had.
std::vector<sync::Bundle> Admissions::what_nobody_sends(const Guest& guest, const View& view) const {
  std::vector<sync::Bundle> all;
  const sync::UpdateLog& log = view.log;
  for (PeerId p = 0; p < session_.slots; ++p) {
    if (p == session_.self) continue;
    const Seat& n = view.roster.seats[p];
    const std::uint32_t end = n.there() ? n.first : log.have(p);
    for (const sync::Bundle& b : log.of(p, guest.have[p])) {
      if (b.index >= end) break;
      all.push_back(b);
    }
  }
  return all;
}

void Admissions::on_enter(const Endpoint& from, const wire::Enter& enter, const View& view, bool may_admit,
                          Commands& out) {
  Guest* guest = guest_at(from, enter.nonce);
  if (guest == nullptr || guest->pieces.empty() || guest->ordered || !may_admit) return;
  if (!knows_all_orders(view)) return;
  const bool taken =
      !is_free(guest->slot, guest->at, view) || guest->incarnation <= view.roster.seats[guest->slot].incarnation;
  if (taken) {  // by a peer that another coordinator admitted; the joiner gets no answer, and begins anew
    std::erase_if(guests_, [guest](const Guest& g) { return &g == guest; });
    return;
  }
  const std::vector<sync::Bundle> unsent = what_nobody_sends(*guest, view);
  // Whose clock was ahead left updates of later ticks than an order now would have; the joiner asks again.
  const auto is_ahead = [&](const sync::Bundle& b) { return b.tick >= view.roster.now; };
  if (std::any_of(unsent.begin(), unsent.end(), is_ahead) || !view.is_over(guest->slot, view.log.have(guest->slot)))
    return;
  guest->ordered = true;
  for (const sync::Bundle& b : unsent) {
    sync::Bundle order;
    order.passed_on.push_back(b);
    out.publish(order);
  }
  sync::Admission a;
  a.slot = guest->slot;
  a.incarnation = guest->incarnation;
  a.first = view.log.have(guest->slot);
  a.at = from;
  a.have = guest->have;
  a.spectator = guest->spectator;
  sync::Bundle order;
  order.admission = std::move(a);
  out.publish(order);
}

void Admissions::pass_on(const Endpoint& from, const wire::Enter& enter, const Endpoint& coordinator, Commands& out) {
  const Guest* guest = guest_at(from, enter.nonce);
  if (guest != nullptr && guest->proven && !guest->ordered && !same_place(coordinator, from))
    out.send(from, wire::Redirect{enter.nonce, coordinator});
}

PeerSet Admissions::returning(const View& view) const {
  PeerSet who = 0;
  for (PeerId p = 0; p < session_.slots; ++p)
    for (const Guest& g : guests_)
      if (g.at.has_key() && !(g.ordered && p == g.slot) && view.roster.seats[p].there() &&
          view.roster.seats[p].at.key == g.at.key)
        who |= only(p);
  return who;
}

void Admissions::advance(Micros local) {
  std::erase_if(guests_, [local](const Guest& g) { return local - g.since > (g.proven ? kStay : kUnproven); });
}

}  // namespace padr::node
