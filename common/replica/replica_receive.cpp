#include <algorithm>

#include "common/replica/replica.h"
#include "common/wire/codec.h"

namespace padr::node {

using sync::DropReason;

namespace {

// Age in ticks above which a repeated update means a lack of acknowledgement; repeats against loss come earlier.
constexpr Tick kLate = 16;
/// Silence after which a peer is excused for what it has not told, ticks. By then the others may have declared it gone.
constexpr Tick kLongSilence = 3 * kTicksPerSecond;

}  // namespace

DropReason Replica::receive(std::span<const std::byte> datagram, Micros now) {
  wire::SealError refused{};
  const auto opened = wire::open(datagram, refused);
  if (opened) return receive(*opened, now);
  objected_ = false;
  ++stats_.datagrams_received;
  ++stats_.dropped[static_cast<std::size_t>(DropReason::kSeal)];
  return DropReason::kSeal;
}

DropReason Replica::receive(const wire::Opened& opened, Micros now) {
  ++stats_.datagrams_received;
  objected_ = false;
  const wire::Header& h = opened.header;
  const bool somebodys = h.kind == wire::Kind::kState && h.session == config_.session && h.sender < config_.slots &&
                         h.sender != config_.self;
  const DropReason why = somebodys ? take(opened, now) : DropReason::kForeign;
  if (why == DropReason::kNone) return why;
  ++stats_.dropped[static_cast<std::size_t>(why)];
  if (somebodys) ++links_[h.sender].dropped[static_cast<std::size_t>(why)];
  return why;
}

void Replica::count_drop(PeerId p, DropReason why) {
  ++stats_.datagrams_received;
  ++stats_.dropped[static_cast<std::size_t>(why)];
  ++links_[p].dropped[static_cast<std::size_t>(why)];
}

DropReason Replica::take(const wire::Opened& opened, Micros now) {
  const wire::Header& h = opened.header;
  Seat& from = roster_.seats[h.sender];
  LinkState& link = links_[h.sender];
  const sync::StatePacket* packet = decoder_.decode(opened.payload, h.sender);
  if (packet == nullptr) return DropReason::kMalformed;
  if (!from.reachable() || packet->incarnation != from.incarnation || packet->to_incarnation != config_.incarnation)
    return DropReason::kForeign;
  if (from.frozen) {
    if (packet->seen_seq > link.answered_seq) roster_.note_answer_of_frozen(h.sender);
    link.answered_seq = std::max(link.answered_seq, packet->seen_seq);
    return DropReason::kForeign;
  }
  const DropReason why = examine(*packet, h.sender);
  if (objected_) return why;
  // Also from datagrams that are ahead of our time: by what it is told of them, a peer with a wrong clock learns so.
  link.clock.sample(packet->mark_tick, now);
  if (packet->transit != 0) link.clock.told(packet->transit);
  if (why != DropReason::kNone) return why;
  link.window.pass(packet->seq);
  link.repeats |= repeats(*packet, h.sender);
  if (breaks_promise(*packet, h.sender)) return DropReason::kPromise;
  const DropReason filed = file_updates(*packet, h.sender);
  if (filed != DropReason::kNone) return filed;
  // After so long a silence it tells what it could not tell meanwhile.
  if (roster_.silence(h.sender) >= kLongSilence) forgive(h.sender, roster_.silence(h.sender));
  from.heard = this->now();
  if (packet->seen_seq > link.answered_seq) {
    link.answered_seq = packet->seen_seq;
    from.proven = true;
    roster_.note_answer(h.sender, packet->mark_tick);
  } else if (packet->have > link.out.acked()) {  // by whatever way it has got it
    roster_.note_answer(h.sender, packet->mark_tick);
  }
  if (packet->mark_tick > link.promised_until) {
    link.promised_until = packet->mark_tick;
    link.promised_below = packet->mark_count;
  }
  link.out.on_packet(*packet, came_at(now));
  link.arrivals.sample(packet->mark_tick, now);
  take_check(*packet, h.sender);
  return DropReason::kNone;
}

DropReason Replica::examine(const sync::StatePacket& packet, PeerId from) {
  const DropReason why = sync::admit(packet, scene_, config_.slots, now());
  if (why != DropReason::kNone) return why;
  if (const DropReason wrong = check_claims(packet, from); wrong != DropReason::kNone) return wrong;
  if (!links_[from].window.would_pass(packet.seq)) return DropReason::kDuplicate;
  const DropReason objection = judge_ ? judge_(packet, kNoPeer) : DropReason::kNone;
  objected_ = objection != DropReason::kNone;
  return objection;
}

// By the session clock. While this peer stands still, its tick does, too, and by that what has waited would have been
// quick. But who is far behind is not to be silent until its ticks have got there.
Tick Replica::came_at(Micros now) const {
  constexpr Tick kMostBehind = 24;
  const Tick tick = tick_at(now) - 1;
  return tick > this->now() && tick <= this->now() + kMostBehind ? tick : this->now();
}

DropReason Replica::check_claims(const sync::StatePacket& packet, PeerId from) const {
  for (const sync::Bundle& b : packet.updates)
    if (!agreed_.log().knows(from, b.index))
      if (const DropReason wrong = sync::admit_claims(b, agreed_.confirmed()); wrong != DropReason::kNone) return wrong;
  return DropReason::kNone;
}

// Whether the packet repeats an update that is here: its sender does not know that the update has arrived.
bool Replica::repeats(const sync::StatePacket& packet, PeerId from) const {
  return std::any_of(packet.updates.begin(), packet.updates.end(), [&](const sync::Bundle& b) {
    return agreed_.log().knows(from, b.index) && packet.mark_tick - b.tick > kLate;
  });
}

// Marks come from the member itself, while what it is complete up to may be an introducer's word. Relayed updates are
// not held to marks.
bool Replica::breaks_promise(const sync::StatePacket& packet, PeerId from) const {
  const LinkState& link = links_[from];
  return std::any_of(packet.updates.begin(), packet.updates.end(), [&](const sync::Bundle& b) {
    return b.tick <= link.promised_until && b.index >= link.promised_below && !agreed_.log().knows(from, b.index);
  });
}

DropReason Replica::file_updates(const sync::StatePacket& packet, PeerId from) {
  const sync::UpdateLog& log = agreed_.log();
  // A tick that was promised to be complete is complete: an unknown update of it contradicts its own sender.
  for (const sync::Bundle& b : packet.updates)
    if (b.index >= log.have(from) && b.tick <= log.complete(from)) return DropReason::kOrder;
  if (log.contradicts(from, packet.mark_tick, packet.mark_count)) return DropReason::kOrder;
  for (const sync::Bundle& b : packet.updates) file(b);
  // An update just filed may have ended the sender's log.
  if (agreed_.log().closed(from)) return DropReason::kNone;
  agreed_.mark(from, packet.mark_tick, packet.mark_count);
  links_[from].promised = std::max(links_[from].promised, packet.mark_count);
  return DropReason::kNone;
}

void Replica::take_check(const sync::StatePacket& packet, PeerId from) {
  if (packet.check_tick < 0 || packet.check_tick % kCheckEvery != 0) return;
  roster_.seats[from].confirmed = std::max(seat(from).confirmed, packet.check_tick);
  if (packet.check_tick <= agreed_.confirmed().tick) {
    compare(packet.check_tick, packet.check_hash, from);
  } else {
    checks_.put_off({packet.check_tick, from, seat(from).incarnation, packet.check_hash});
  }
}

void Replica::settle_checks() {
  HashChecks::Told told;
  while (checks_.take(agreed_.confirmed().tick, told))
    if (seat(told.from).incarnation == told.incarnation) compare(told.tick, told.hash, told.from);
}

// Not of a peer that was removed or left meanwhile: it may go its own way, as nobody waits for its updates.
void Replica::compare(Tick t, std::uint32_t theirs, PeerId from) {
  if (!seat(from).there()) return;
  const HashChecks::Own* mine = checks_.own(t);
  if (mine == nullptr) return;
  ++stats_.hash_checks;
  Seat& other = roster_.seats[from];
  if (mine->hash == theirs) {
    if (!other.differs) other.same = std::max(other.same, t);
    return;
  }
  ++stats_.hash_mismatches;
  if (stats_.first_mismatch < 0) stats_.first_mismatch = t;
  differs_from_ = std::min(differs_from_, from);
  if (other.differs) return;
  other.differs = true;
  other.differs_at = t;
  other.disputed = now();
}

}  // namespace padr::node
