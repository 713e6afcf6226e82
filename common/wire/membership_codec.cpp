#include "common/wire/membership_codec.h"

#include <algorithm>
#include <cassert>

#include "common/wire/codec.h"
#include "common/wire/endpoint_codec.h"
#include "common/wire/update_codec.h"
#include "proto/wire.pb.h"

namespace padr::wire {
namespace {

using google::protobuf::RepeatedPtrField;

void put_seats(const std::vector<Seat>& seats, RepeatedPtrField<Membership::Seat>& out) {
  for (const Seat& s : seats) {
    Membership::Seat& seat = *out.Add();
    seat.set_slot(s.slot);
    seat.set_incarnation(s.incarnation);
    seat.set_have(s.have);
    seat.set_heard(s.heard);
  }
}

bool ascends(const sync::Bundle& before, const sync::Bundle& b) {
  return b.index > before.index && b.tick > before.tick;
}

struct Encoder {
  Membership& out;

  void operator()(const Pull& m) const {
    out.mutable_pull()->set_nonce(m.nonce);
    out.mutable_pull()->set_from(m.from);
    out.mutable_pull()->set_wanted(m.wanted);
    out.mutable_pull()->set_cookie(m.cookie);
  }
  void operator()(const Piece& m) const {
    auto& p = *out.mutable_piece();
    p.set_nonce(m.nonce);
    p.set_index(m.index);
    p.set_count(m.count);
    p.set_bytes(m.bytes.data(), m.bytes.size());
  }
  void operator()(const Enter& m) const { out.mutable_enter()->set_nonce(m.nonce); }
  void operator()(const Poll& m) const {
    put_seats(m.lost, *out.mutable_poll()->mutable_lost());
    out.mutable_poll()->set_freeze(m.freeze);
    out.mutable_poll()->set_number(m.number);
  }
  void operator()(const Answer& m) const {
    put_seats(m.lost, *out.mutable_answer()->mutable_lost());
    out.mutable_answer()->set_frozen(m.frozen);
    out.mutable_answer()->set_tick(static_cast<std::uint32_t>(m.tick));
    out.mutable_answer()->set_number(m.number);
  }
  void operator()(const Fetch& m) const {
    out.mutable_fetch()->set_slot(m.slot);
    out.mutable_fetch()->set_incarnation(m.incarnation);
    out.mutable_fetch()->set_from(m.from);
  }
  void operator()(const Fetched& m) const {
    auto& f = *out.mutable_fetched();
    f.set_slot(m.slot);
    f.set_incarnation(m.incarnation);
    assert(!m.updates.empty());
    std::size_t used = kStateOverhead;
    std::size_t n = 0;
    for (; n < m.updates.size(); ++n) {
      used += encoded_size(m.updates[n]);
      if (n > 0 && (used > kMaxPayload || !ascends(m.updates[n - 1], m.updates[n]))) break;
    }
    const Tick mark_tick = m.updates[n - 1].tick;
    const std::uint32_t mark_count = m.updates[n - 1].index + 1;
    f.mutable_updates()->set_mark_tick(static_cast<std::uint32_t>(mark_tick));
    f.mutable_updates()->set_mark_count(mark_count);
    for (std::size_t i = 0; i < n; ++i)
      put_update(m.updates[i], mark_tick, mark_count, *f.mutable_updates()->add_updates());
  }
  void operator()(const Probe& m) const {
    auto& p = *out.mutable_probe();
    p.set_incarnation(m.incarnation);
    put_seats(m.members, *p.mutable_members());
    p.set_knows_you(m.knows_you);
    p.set_newest(m.newest);
    p.set_yields(m.yields);
  }
  void operator()(const Reach& m) const {
    out.mutable_reach()->set_tick(static_cast<std::uint32_t>(m.tick));
    for (const Way& w : m.heard) {
      Membership::Way& way = *out.mutable_reach()->add_heard();
      way.set_slot(w.slot);
      way.set_delay(w.delay);
      way.set_carried(w.carried);
    }
    for (const Endpoint& e : m.at) put_endpoint(e.place(), *out.mutable_reach()->add_at());
  }
  void operator()(const Newcomer& m) const { put_endpoint(m.at, *out.mutable_newcomer()); }
};

constexpr std::uint32_t kMaxTick = 0x7FFFFFFF;

using Taken = std::optional<MembershipMessage>;

Taken take(const Membership::Pull& in) {
  if (in.nonce() == 0 || in.from() >= kMaxPieces || in.cookie() == 0) return std::nullopt;
  return Pull{in.nonce(), in.from(), in.wanted(), in.cookie()};
}

Taken take(const Membership::Piece& in) {
  if (in.nonce() == 0 || in.count() > kMaxPieces || in.index() >= in.count()) return std::nullopt;
  if (in.bytes().empty() || in.bytes().size() > kPieceBytes) return std::nullopt;
  Piece p{in.nonce(), in.index(), in.count(), Bytes(in.bytes().size())};
  std::transform(in.bytes().begin(), in.bytes().end(), p.bytes.begin(),
                 [](char c) { return static_cast<std::byte>(c); });
  return p;
}

Taken take(const Membership::Enter& in) {
  if (in.nonce() == 0) return std::nullopt;
  return Enter{in.nonce()};
}

bool take_seats(const RepeatedPtrField<Membership::Seat>& in, std::size_t most, std::vector<Seat>& out) {
  if (in.empty() || static_cast<std::size_t>(in.size()) > most) return false;
  for (const Membership::Seat& s : in) {
    if (s.slot() >= kMaxPeers || (!out.empty() && s.slot() <= out.back().slot) || s.heard() > kMostHeard) return false;
    out.push_back({static_cast<PeerId>(s.slot()), s.incarnation(), s.have(), s.heard()});
  }
  return true;
}

Taken take(const Membership::Poll& in) {
  if (in.number() > kMostPollNumber) return std::nullopt;
  Poll m{{}, in.freeze(), in.number()};
  if (!take_seats(in.lost(), kMostLost, m.lost)) return std::nullopt;
  return m;
}

Taken take(const Membership::Answer& in) {
  if (in.tick() > kMaxTick || in.number() > kMostPollNumber) return std::nullopt;
  Answer m{{}, in.frozen(), static_cast<Tick>(in.tick()), in.number()};
  if (!take_seats(in.lost(), kMostLost, m.lost)) return std::nullopt;
  return m;
}

Taken take(const Membership::Fetch& in) {
  if (in.slot() >= kMaxPeers) return std::nullopt;
  return Fetch{static_cast<PeerId>(in.slot()), in.incarnation(), in.from()};
}

Taken take(const Membership::Fetched& in) {
  if (in.slot() >= kMaxPeers || in.updates().updates_size() == 0 || in.updates().mark_tick() >= kMaxTick)
    return std::nullopt;
  Fetched f{static_cast<PeerId>(in.slot()), in.incarnation(), {}};
  for (const Update& u : in.updates().updates()) {
    sync::Bundle& b = f.updates.emplace_back();
    b.peer = f.slot;
    if (!take_update(u, static_cast<Tick>(in.updates().mark_tick()), in.updates().mark_count(), b)) return std::nullopt;
    if (f.updates.size() == 1) continue;
    const sync::Bundle& before = f.updates[f.updates.size() - 2];
    if (!ascends(before, b)) return std::nullopt;
  }
  return f;
}

Taken take(const Membership::Probe& in) {
  Probe p{in.incarnation(), {}, in.knows_you(), in.newest(), in.yields()};
  if (!take_seats(in.members(), kMaxPeers, p.members)) return std::nullopt;
  return p;
}

Taken take(const Membership::Reach& in) {
  if (in.tick() > kMaxTick || static_cast<std::size_t>(in.heard_size()) > kMaxPeers) return std::nullopt;
  Reach m{static_cast<Tick>(in.tick()), {}};
  for (const Membership::Way& w : in.heard()) {
    if (w.slot() >= kMaxPeers || w.delay() > kMostDelay) return std::nullopt;
    if (!m.heard.empty() && w.slot() <= m.heard.back().slot) return std::nullopt;
    m.heard.push_back({static_cast<PeerId>(w.slot()), w.delay(), w.carried()});
  }
  if (static_cast<std::size_t>(in.at_size()) > kMostOwnAddresses) return std::nullopt;
  for (const Membership::Place& p : in.at())
    if (!take_endpoint(p, m.at.emplace_back()) || m.at.back().has_key()) return std::nullopt;
  return m;
}

Taken take(const Membership::Newcomer& in) {
  Newcomer m;
  if (!take_endpoint(in, m.at)) return std::nullopt;
  return m;
}

}  // namespace

Bytes encode_membership(const MembershipMessage& message) {
  Membership out;
  std::visit(Encoder{out}, message);
  Bytes bytes(out.ByteSizeLong());
  out.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

std::optional<MembershipMessage> decode_membership(std::span<const std::byte> payload) {
  Membership in;
  if (!in.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) return std::nullopt;
  switch (in.kind_case()) {
    case Membership::kPull:
      return take(in.pull());
    case Membership::kPiece:
      return take(in.piece());
    case Membership::kEnter:
      return take(in.enter());
    case Membership::kPoll:
      return take(in.poll());
    case Membership::kAnswer:
      return take(in.answer());
    case Membership::kFetch:
      return take(in.fetch());
    case Membership::kFetched:
      return take(in.fetched());
    case Membership::kProbe:
      return take(in.probe());
    case Membership::kReach:
      return take(in.reach());
    case Membership::kNewcomer:
      return take(in.newcomer());
    case Membership::KIND_NOT_SET:
      break;
  }
  return std::nullopt;
}

}  // namespace padr::wire
