#include "common/node/doorkeeper.h"

#include <algorithm>

#include "common/node/session_objection.h"
#include "common/wire/secret.h"
#include "common/wire/transfer_codec.h"

namespace padr::node {
namespace {

/// A newcomer takes well under a second; what is in the transfer stays to be had for longer than this.
constexpr Micros kStay = 8 * kMicrosPerSecond;
/// At most so many pieces in answer to one Pull.
constexpr int kBurst = 64;
constexpr std::uint64_t kSpread = 127;
/// A slot whose peer has been silent for so long may come free.
constexpr Tick kMayBeGone = kTicksPerSecond;

}  // namespace

Doorkeeper::Guest* Doorkeeper::guest_at(const Endpoint& where, std::uint64_t nonce) {
  const auto it =
      std::find_if(guests_.begin(), guests_.end(), [&](const Guest& g) { return g.at == where && g.nonce == nonce; });
  return it == guests_.end() ? nullptr : &*it;
}

// Not 0.
std::uint64_t Doorkeeper::cookie_for(const Endpoint& where, std::uint64_t nonce) const {
  wire::Key key{};
  for (unsigned i = 0; i < 8; ++i) key[i] = static_cast<std::uint8_t>(desk_.config.secret >> (8 * i));
  wire::Bytes text;
  for (const std::uint8_t b : where.address) text.push_back(static_cast<std::byte>(b));
  for (unsigned i = 0; i < 16; i += 8) text.push_back(static_cast<std::byte>(where.port >> i));
  for (unsigned i = 0; i < 64; i += 8) text.push_back(static_cast<std::byte>(nonce >> i));
  const wire::Tag tag = wire::tag_of(key, text);
  std::uint64_t cookie = 0;
  for (unsigned i = 0; i < 8; ++i) cookie |= std::to_integer<std::uint64_t>(tag[i]) << (8 * i);
  return std::max<std::uint64_t>(cookie, 1);
}

void Doorkeeper::refuse(const Endpoint& from, const wire::Join& join, const std::string& reason) {
  desk_.send(from, wire::Refuse{join.nonce, reason});
  desk_.note("refused " + to_string(from) + ": " + reason, true);
}

void Doorkeeper::on_join(const Endpoint& from, const wire::Join& join, const RecordedNode& node, Micros local) {
  if (!desk_.may_answer(local)) return;
  Guest* guest = guest_at(from, join.nonce);
  if (guest == nullptr) {
    const std::string reason = objection(desk_.config, join);
    if (!reason.empty()) return refuse(from, join, reason);
    guest = take_in(from, join, node.node(), local);
    if (guest == nullptr) return;
  }
  wire::Welcome w;
  w.nonce = join.nonce;
  w.peer = guest->slot;
  w.slots = desk_.slots;
  w.wanted = desk_.wanted;
  w.running = true;
  w.incarnation = guest->incarnation;
  w.cookie = guest->cookie;
  desk_.send(from, w);
}

Doorkeeper::Guest* Doorkeeper::take_in(const Endpoint& from, const wire::Join& join, const Node& node, Micros local) {
  std::erase_if(guests_, [&](const Guest& g) { return same_place(g.at, from) && !g.ordered; });  // started anew
  const auto slot = free_slot(node);
  if (!slot) {
    if (!may_come_free(node))
      refuse(from, join,
             "the session is full: " + std::to_string(desk_.slots) + " of " + std::to_string(desk_.slots) +
                 " slots are taken");
    return nullptr;
  }
  Guest g;
  g.at = from;
  g.nonce = join.nonce;
  g.cookie = cookie_for(from, join.nonce);
  g.slot = *slot;
  g.since = local;
  // Never the number of anybody else's: late datagrams tell by it whom they mean.
  g.incarnation = node.newest_incarnation();
  for (const Guest& other : guests_) g.incarnation = std::max(g.incarnation, other.incarnation);
  // And hardly ever one that another side of a partition gives at the same time.
  g.incarnation += 1 + static_cast<std::uint32_t>(join.nonce % kSpread);
  guests_.push_back(std::move(g));
  return &guests_.back();
}

bool Doorkeeper::is_free(PeerId p, const Node& node) const {
  const sync::UpdateLog& log = node.agreed().log();
  const bool empty = !node.other(p).reachable() || node.departed(p);
  return p != desk_.self && empty && log.closed(p) && !log.waits(p);
}

std::optional<PeerId> Doorkeeper::free_slot(const Node& node) const {
  for (PeerId p = 0; p < desk_.slots; ++p) {
    const bool promised = std::any_of(guests_.begin(), guests_.end(), [p](const Guest& g) { return g.slot == p; });
    if (is_free(p, node) && !promised) return p;
  }
  return std::nullopt;
}

// Who was the coordinator before has left, and may have let somebody in with a word that is not here yet.
bool Doorkeeper::knows_all_orders(const Node& node) const {
  const sync::UpdateLog& log = node.agreed().log();
  for (PeerId p = 0; p < desk_.slots; ++p)
    if (p != desk_.self && log.closed(p) && log.waits(p)) return false;
  return true;
}

bool Doorkeeper::may_come_free(const Node& node) const {
  if (!guests_.empty()) return true;
  for (PeerId p = 0; p < desk_.slots; ++p) {
    const Neighbour& n = node.other(p);
    if (p != desk_.self && (!n.there() || node.unanswered(p) > kMayBeGone)) return true;
  }
  return false;
}

bool Doorkeeper::on_ping(const Endpoint& from, const wire::Ping& ping, Micros local) {
  const bool known = std::any_of(guests_.begin(), guests_.end(), [&](const Guest& g) { return g.at == from; });
  if (known) desk_.send(from, wire::Pong{ping.sent, desk_.clock.now(local), desk_.present});
  return known;
}

void Doorkeeper::on_pull(const Endpoint& from, const wire::Pull& pull, const RecordedNode& node,
                         std::vector<Endpoint> gone) {
  Guest* guest = guest_at(from, pull.nonce);
  // What is in all pieces is many times as long as a Pull: whoever cannot be there gets nothing.
  if (guest == nullptr || pull.cookie != guest->cookie) return;
  guest->proven = true;
  if (guest->pieces.empty()) {
    sync::Transfer t = node.node().transfer();
    t.gone = std::move(gone);
    const wire::Bytes all = wire::encode_transfer(t);
    guest->have = t.have;
    for (std::size_t at = 0; at < all.size(); at += wire::kPieceBytes) {
      const std::size_t n = std::min(wire::kPieceBytes, all.size() - at);
      guest->pieces.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                                 all.begin() + static_cast<std::ptrdiff_t>(at + n));
    }
  }
  const auto count = static_cast<std::uint32_t>(guest->pieces.size());
  for (std::uint32_t i = 0; i < kBurst && pull.from + i < count; ++i)
    if ((pull.wanted >> i & 1U) != 0)
      desk_.send(from, wire::Piece{pull.nonce, pull.from + i, count, guest->pieces[pull.from + i]});
}

// Who was removed, or has left and ended, since the guest was given the world sends it nothing, and the rest had no
// reason to pass on what all of them had.
void Doorkeeper::pass_on_what_nobody_sends(const Guest& guest, RecordedNode& node) {
  const sync::UpdateLog& log = node.node().agreed().log();
  for (PeerId p = 0; p < desk_.slots; ++p) {
    if (p == desk_.self) continue;
    const Neighbour& n = node.node().other(p);
    const std::uint32_t end = n.there() ? n.first : log.have(p);
    for (const sync::Bundle& b : log.of(p, guest.have[p])) {
      if (b.index >= end) break;
      sync::Bundle order;
      order.passed_on.push_back(b);
      node.order(order);
    }
  }
}

void Doorkeeper::on_enter(const Endpoint& from, const wire::Enter& enter, RecordedNode& node, bool may_admit) {
  Guest* guest = guest_at(from, enter.nonce);
  if (guest == nullptr || guest->pieces.empty() || guest->ordered || !may_admit) return;
  if (!knows_all_orders(node.node())) return;
  const bool taken =
      !is_free(guest->slot, node.node()) || guest->incarnation <= node.node().other(guest->slot).incarnation;
  if (taken) {  // by whom another coordinator has let in meanwhile; the guest misses our answers, and begins anew
    std::erase_if(guests_, [guest](const Guest& g) { return &g == guest; });
    return;
  }
  guest->ordered = true;
  pass_on_what_nobody_sends(*guest, node);
  sync::Admission a;
  a.slot = guest->slot;
  a.incarnation = guest->incarnation;
  a.first = node.node().agreed().log().have(guest->slot);
  a.at = from;
  a.have = guest->have;
  sync::Bundle order;
  order.admission = std::move(a);
  node.order(order);
}

void Doorkeeper::pass_on(const Endpoint& from, const wire::Enter& enter, const Endpoint& coordinator) {
  const Guest* guest = guest_at(from, enter.nonce);
  if (guest != nullptr && guest->proven && !guest->ordered && !same_place(coordinator, from))
    desk_.send(from, wire::Redirect{enter.nonce, coordinator});
}

void Doorkeeper::advance(Micros local) {
  std::erase_if(guests_, [local](const Guest& g) { return local - g.since > kStay; });
}

}  // namespace padr::node
