#include "tools/capture/tally.h"

#include <algorithm>

#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"
#include "tools/capture/names.h"

namespace padr::capture {
namespace {

// More than any real session has, so that a forged capture cannot fill the memory.
constexpr std::size_t kMostSessions = 64;
constexpr std::size_t kMostLives = 1024;
constexpr std::size_t kMostLinks = 2048;
constexpr std::size_t kMostUnacked = 256;
constexpr std::size_t kMostPings = 65536;
constexpr std::uint64_t kEnough = 20;         // datagrams, for one of them to have been about as fast as any
constexpr std::int64_t kClocksDiffer = 5000;  // us: so far apart the session clocks of peers may be
constexpr std::size_t kEnvelope = wire::kHeaderBytes + wire::kTagBytes;

void keep_greatest(std::optional<std::int64_t>& greatest, std::int64_t v) {
  greatest = greatest ? std::max(*greatest, v) : v;
}

/// Whether a frame's address is that of this peer, and not of one that carries for it, or what a NAT makes of it.
bool shows(const Datagram& d, const Endpoint& peer, const Endpoint& outer) {
  return outer == peer || (!peer.is_set() && !d.carried_to);
}

/// The entry of this key, made if there is none and room for it; null otherwise.
template <typename Map>
typename Map::mapped_type* entry(Map& map, const typename Map::key_type& key, std::size_t most) {
  const auto found = map.lower_bound(key);
  if (found != map.end() && found->first == key) return &found->second;
  if (map.size() >= most) return nullptr;
  return &map.try_emplace(found, key)->second;
}

}  // namespace

void Traffic::add(const Datagram& d) {
  const auto size = static_cast<std::uint32_t>(d.cut ? d.payload_bytes : d.payload.size() + d.seal_bytes);
  if (datagrams++ == 0) {
    first_ns = last_ns = d.time_ns;
    least_size = size;
  }
  first_ns = std::min(first_ns, d.time_ns);
  last_ns = std::max(last_ns, d.time_ns);
  bytes += d.wire_bytes;
  header_bytes += d.wire_bytes - std::min<std::size_t>(d.wire_bytes, size);
  const std::size_t envelope = std::min<std::size_t>(kEnvelope, d.cut ? size : d.payload.size());
  envelope_bytes += envelope + d.seal_bytes;
  if (d.cut) cut_bytes += size - envelope;
  least_size = std::min(least_size, size);
  most_size = std::max(most_size, size);
}

// Where the capture is beside who asks, tick 0 seems earlier by the way to whoever answers. But nothing is sooner at
// its receiver than in the capture, so the delays that receivers tell say by how much.
std::pair<std::int64_t, bool> Tally::tick0(std::uint16_t session) const {
  const SessionTally& s = sessions_.at(session);
  if (!s.session_us) return {s.least_us, false};
  std::int64_t late = 0;
  for (const auto& [key, link] : links_) {
    if (key.from.session != session || !link.transit || link.delays.count() < kEnough) continue;
    late = std::max(late, link.delays.least_us() - *s.session_us - std::int64_t{100} * *link.transit);
  }
  return {*s.session_us + (late > kClocksDiffer ? late : 0), true};
}

PeerId Tally::receiver(const LinkKey& link) const {
  const auto found = who_.find({link.to, link.to_incarnation});
  return found == who_.end() ? kNoPeer : found->second.slot;
}

void Tally::take(const Datagram& d) {
  all_.add(d);
  if (d.cut) {
    ++dropped_["cut off by the capture"];
    ++cut_;
    return;
  }
  wire::SealError why = wire::SealError::kNone;
  const auto opened = wire::open(d.payload, why);
  if (!opened) {
    ++dropped_[std::string(name_of(why))];
    return;
  }
  kinds_[static_cast<std::size_t>(opened->header.kind)].add(d);
  if (d.second_hop) return second_hop(d, *opened);
  switch (opened->header.kind) {
    case wire::Kind::kState:
      return state(d, *opened);
    case wire::Kind::kSession:
      return session(d, *opened);
    case wire::Kind::kMembership:
      return membership(*opened);
    case wire::Kind::kCarried:
      break;  // never opened
  }
}

void Tally::second_hop(const Datagram& d, const wire::Opened& o) {
  const bool is_state = o.header.kind == wire::Kind::kState;
  std::uint64_t updates = 0;
  if (is_state && wire::scan_state(o.payload, scan_))
    for (const auto& u : scan_.updates) updates += u.bytes;
  if (is_state) {
    const auto link = links_.find({{o.header.session, o.header.sender, scan_.incarnation}, d.to, scan_.to_incarnation});
    if (link != links_.end()) link->second.passed_on = true;
  }
  updates = std::min<std::uint64_t>(updates, o.payload.size());
  for (Traffic* t : {&all_, &kinds_[static_cast<std::size_t>(o.header.kind)]}) {
    t->repeat_bytes += updates;
    (is_state ? t->mark_bytes : t->other_bytes) += o.payload.size() - updates;
  }
}

void Tally::state(const Datagram& d, const wire::Opened& o) {
  if (!wire::scan_state(o.payload, scan_) || o.header.sender >= kMaxPeers) {
    ++dropped_["malformed"];
    return;
  }
  const LifeKey from{o.header.session, o.header.sender, scan_.incarnation};
  SessionTally* s = entry(sessions_, from.session, kMostSessions);
  LifeTally* who = entry(incarnations_, from, kMostLives);
  LinkTally* link = entry(links_, {from, d.to, scan_.to_incarnation}, kMostLinks);
  if (s == nullptr || who == nullptr || link == nullptr) {
    ++beyond_;
    return;
  }
  const std::int64_t ahead = d.time_ns / 1000 - tick_start(static_cast<Tick>(scan_.mark_tick));
  if (s->states++ == 0) {
    s->first_tick = scan_.mark_tick;
    s->least_us = ahead;
  }
  s->first_tick = std::min(s->first_tick, scan_.mark_tick);
  s->last_tick = std::max(s->last_tick, scan_.mark_tick);
  s->least_us = std::min(s->least_us, ahead);
  if (scan_.check_hash != 0) ++s->hashes;
  if (who->traffic.datagrams == 0 || shows(d, d.from, d.outer_from)) who->at = d.outer_from;
  if (link->traffic.datagrams == 0 || shows(d, d.to, d.outer_to)) link->at = d.outer_to;
  if (who->traffic.datagrams == 0 || who->place != d.from) {
    who->place = d.from;
    if (who_.size() < 4 * kMostLives) who_[{d.from, from.incarnation}] = from;
  }
  acknowledge(d, from);
  state_of_life(d, *who);
  link->delays.add(ahead);
  const std::uint64_t repeated = state_of_link(d, *link);
  std::uint64_t updates = 0;
  for (const auto& u : scan_.updates) updates += u.bytes;
  for (Traffic* t : {&all_, &kinds_[0], &who->traffic, &link->traffic}) {
    t->update_bytes += updates - repeated;
    t->repeat_bytes += repeated;
    t->mark_bytes += o.payload.size() - std::min<std::uint64_t>(updates, o.payload.size());
  }
}

void Tally::state_of_life(const Datagram& d, LifeTally& who) {
  who.traffic.add(d);
  for (const auto& u : scan_.updates) {
    if (who.told.add(u.index) == NumberWindow::Seen::kAgain) continue;
    for (std::size_t c = 0; c < u.causes.size(); ++c) who.updates[c] += u.causes[c];
    who.left |= u.leave;
  }
}

/// Returns how many bytes were of updates that the link had carried before.
std::uint64_t Tally::state_of_link(const Datagram& d, LinkTally& link) {
  if (link.traffic.datagrams > 0) link.gaps.add((d.time_ns - link.traffic.last_ns) / 1000);
  link.traffic.add(d);
  link.direct = link.direct || !d.carried_to;
  const auto seen = link.seqs.add(scan_.seq);
  if (seen == NumberWindow::Seen::kAgain) ++link.duplicates;
  if (seen == NumberWindow::Seen::kNewLate) ++link.reordered;
  if (scan_.updates.empty()) ++link.marks;
  std::uint64_t again = 0;
  for (const auto& u : scan_.updates) {
    if (link.told.add(u.index) == NumberWindow::Seen::kAgain) {
      again += u.bytes;
      if (seen != NumberWindow::Seen::kAgain) ++link.repeats;
    } else {
      link.unacked.emplace_back(u.index, d.time_ns);
      if (link.unacked.size() > kMostUnacked) link.unacked.pop_front();
    }
  }
  return again;
}

/// What the datagram says of the link the other way.
void Tally::acknowledge(const Datagram& d, const LifeKey& from) {
  const auto other = who_.find({d.to, scan_.to_incarnation});
  if (other == who_.end()) return;
  const auto found = links_.find({other->second, d.from, from.incarnation});
  if (found == links_.end()) return;
  LinkTally& back = found->second;
  if (scan_.transit != 0 && (!back.transit || scan_.transit < *back.transit)) back.transit = scan_.transit;
  if (scan_.transit != 0) {  // told in the same datagrams
    back.told_loss.add(back.seqs.lowest(), back.seqs.highest(), scan_.loss);
  }
  std::erase_if(back.unacked, [&](const auto& u) {
    const bool beyond = u.first > scan_.have && u.first - scan_.have <= 32 &&
                        (scan_.have_beyond >> (u.first - scan_.have - 1) & 1U) != 0;
    if (u.first >= scan_.have && !beyond) return false;
    back.acks.add((d.time_ns - u.second) / 1000);
    return true;
  });
}

void Tally::session(const Datagram& d, const wire::Opened& o) {
  const auto message = wire::decode_session(o.payload);
  if (!message) {
    ++dropped_["malformed"];
    return;
  }
  ++messages_[std::string(name_of(*message))];
  for (Traffic* t : {&all_, &kinds_[1]}) t->other_bytes += o.payload.size();
  // A Join knows no session yet: it is told with whatever session is spoken of next.
  SessionTally* s = entry(sessions_, o.header.session, kMostSessions);
  if (s == nullptr) return;
  if (const auto* join = std::get_if<wire::Join>(&*message)) {
    s->scenario = join->scenario;
    s->authority = join->authority;
    s->join_seen = true;
  } else if (const auto* welcome = std::get_if<wire::Welcome>(&*message)) {
    s->slots = welcome->slots;
    s->wanted = welcome->wanted;
    const SessionTally& asked = sessions_[0];
    if (asked.join_seen) {
      s->scenario = asked.scenario;
      s->authority = asked.authority;
      s->join_seen = true;
    }
  } else if (const auto* ping = std::get_if<wire::Ping>(&*message)) {
    if (pings_.size() < kMostPings) pings_.try_emplace({d.from, ping->sent}, d.time_ns / 1000);
  } else if (const auto* pong = std::get_if<wire::Pong>(&*message)) {
    const auto asked = pings_.find({d.to, pong->sent});
    if (asked != pings_.end()) keep_greatest(s->session_us, asked->second - pong->session);
  }
}

void Tally::membership(const wire::Opened& o) {
  const auto message = wire::decode_membership(o.payload);
  if (!message) {
    ++dropped_["malformed"];
    return;
  }
  ++messages_[std::string(name_of(*message))];
  for (Traffic* t : {&all_, &kinds_[2]}) t->other_bytes += o.payload.size();
}

}  // namespace padr::capture
