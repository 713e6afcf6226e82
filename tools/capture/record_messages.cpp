// The kinds of datagrams as fields.
#include "common/wire/codec.h"
#include "common/wire/field_reader.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"
#include "tools/capture/names.h"
#include "tools/capture/record.h"
#include "tools/capture/record_update.h"

namespace padr::capture {
namespace {

using Bytes = std::span<const std::byte>;

std::uint64_t bodies_in(const std::vector<sync::Bundle>& updates) {
  std::uint64_t n = 0;
  for (const sync::Bundle& b : updates) n += b.bodies.size() + bodies_in(b.passed_on);
  return n;
}

/// How long the last field `inner` (bytes) of the message in field `outer` is.
std::size_t length_within(Bytes payload, std::uint32_t outer, std::uint32_t inner) {
  std::size_t length = 0;
  for (wire::FieldReader f(payload); f.next();) {
    if (f.number != outer || f.type != 2) continue;
    for (wire::FieldReader g(f.bytes); g.next();)
      if (g.number == inner && g.type == 2) length = g.bytes.size();
  }
  return length;
}

class SessionFields {
 public:
  SessionFields(Record& r, Bytes payload) : r_(r), payload_(payload) {}

  void operator()(const wire::Join& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.hex64("padr.join.scene_hash", m.scene_hash);
    r_.hex64("padr.join.fingerprint", m.fingerprint);
    r_.flag("padr.join.authority", m.authority);
    r_.text("padr.join.scenario", m.scenario);
    r_.number("padr.join.padding", length_within(payload_, 1, 6));
    r_.flag("padr.join.spectator", m.spectator);
  }
  void operator()(const wire::Welcome& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.number("padr.welcome.peer", m.peer);
    r_.number("padr.welcome.slots", static_cast<std::uint64_t>(m.slots));
    r_.number("padr.welcome.wanted", static_cast<std::uint64_t>(m.wanted));
    r_.number("padr.welcome.incarnation", m.incarnation);
    r_.hex64("padr.welcome.cookie", m.cookie);
    if (m.session != SessionId{}) r_.bytes("padr.welcome.session", std::as_bytes(std::span(m.session)));
  }
  void operator()(const wire::Redirect& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.address("padr.redirect.address", m.to);
    r_.number("padr.redirect.port", m.to.port);
  }
  void operator()(const wire::Refuse& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.text("padr.refuse.reason", m.reason);
  }
  void operator()(const wire::Ping& m) const {
    r_.signed_number("padr.ping.sent_us", m.sent);
    r_.number("padr.ping.padding", length_within(payload_, 5, 2));
  }
  void operator()(const wire::Pong& m) const {
    r_.signed_number("padr.pong.sent_us", m.sent);
    r_.signed_number("padr.pong.session_us", m.session);
  }
  void operator()(const wire::Ask& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.hex64("padr.ask.crowd", m.crowd);
    r_.number("padr.ask.about", m.about);
    regions({"padr.ask.in", "padr.ask.seeks"}, m.sender);
    r_.number("padr.ask.rank", m.rank);
    r_.number("padr.ask.padding", length_within(payload_, 10, 7));
  }
  void operator()(const wire::Tell& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.hex64("padr.tell.crowd", m.crowd);
    r_.number("padr.tell.about", m.about);
    regions({"padr.tell.in", "padr.tell.seeks"}, m.sender);
    r_.number("padr.tell.rank", m.rank);
    r_.signed_number("padr.tell.clock_us", m.clock);
    for (const wire::Acquaintance& k : m.known) {
      r_.address("padr.tell.known.address", k.at);
      r_.number("padr.tell.known.port", k.at.port);
      regions({"padr.tell.known.in", "padr.tell.known.seeks"}, k.where);
    }
    r_.flag("padr.tell.noted", m.noted);
  }

 private:
  struct RegionNames {
    std::string_view in, seeks;
  };
  void regions(const RegionNames& names, const wire::Whereabouts& w) const {
    for (const std::uint32_t r : w.in) r_.number(names.in, r);
    for (const std::uint32_t r : w.seeks) r_.number(names.seeks, r);
  }

  Record& r_;
  Bytes payload_;
};

struct SeatNames {
  std::string_view slot, incarnation, have, heard;
};

class MembershipFields {
 public:
  MembershipFields(Record& r, Bytes payload) : r_(r), payload_(payload) {}

  void operator()(const wire::Pull& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.number("padr.pull.from", m.from);
    r_.hex64("padr.pull.wanted", m.wanted);
    r_.hex64("padr.pull.cookie", m.cookie);
  }
  void operator()(const wire::Piece& m) const {
    r_.hex64("padr.nonce", m.nonce);
    r_.number("padr.piece.index", m.index);
    r_.number("padr.piece.count", m.count);
    r_.bytes("padr.piece.bytes", m.bytes);
  }
  void operator()(const wire::Enter& m) const { r_.hex64("padr.nonce", m.nonce); }
  void operator()(const wire::Poll& m) const {
    seats(m.lost, {"padr.poll.lost.slot", "padr.poll.lost.incarnation", "padr.poll.lost.have", "padr.poll.lost.heard"});
    r_.flag("padr.poll.freeze", m.freeze);
    r_.number("padr.poll.number", m.number);
  }
  void operator()(const wire::Answer& m) const {
    seats(m.lost,
          {"padr.answer.lost.slot", "padr.answer.lost.incarnation", "padr.answer.lost.have", "padr.answer.lost.heard"});
    r_.flag("padr.answer.frozen", m.frozen);
    r_.number("padr.answer.tick", static_cast<std::uint32_t>(m.tick));
    r_.number("padr.answer.number", m.number);
  }
  void operator()(const wire::Fetch& m) const {
    r_.number("padr.fetch.slot", m.slot);
    r_.number("padr.fetch.incarnation", m.incarnation);
    r_.number("padr.fetch.from", m.from);
  }
  void operator()(const wire::Fetched& m) const {
    // The decoder keeps what the updates say, not what they count back from.
    std::uint32_t mark_tick = 0;
    std::uint32_t mark_count = 0;
    for (wire::FieldReader f(payload_); f.next();) {
      if (f.number != 7 || f.type != 2) continue;
      for (wire::FieldReader g(f.bytes); g.next();) {
        if (g.number != 3 || g.type != 2) continue;
        for (wire::FieldReader h(g.bytes); h.next();) {
          if (h.number == 2 && h.type == 0) mark_tick = h.u32();
          if (h.number == 3 && h.type == 0) mark_count = h.u32();
        }
      }
    }
    r_.number("padr.fetched.slot", m.slot);
    r_.number("padr.fetched.incarnation", m.incarnation);
    r_.number("padr.fetched.mark_tick", mark_tick);
    r_.number("padr.fetched.mark_count", mark_count);
    for (sync::Bundle b : m.updates) {
      b.peer = m.slot;
      put_update(r_, b, static_cast<Tick>(mark_tick), mark_count);
    }
  }
  void operator()(const wire::Probe& m) const {
    r_.number("padr.probe.incarnation", m.incarnation);
    seats(m.members, {"padr.probe.members.slot", "padr.probe.members.incarnation", "padr.probe.members.have",
                      "padr.probe.members.heard"});
    r_.flag("padr.probe.knows_you", m.knows_you);
    r_.number("padr.probe.newest", m.newest);
    r_.flag("padr.probe.yields", m.yields);
  }
  void operator()(const wire::Reach& m) const {
    r_.number("padr.reach.tick", static_cast<std::uint64_t>(m.tick));
    for (const wire::Way& w : m.heard) {
      r_.number("padr.reach.heard.slot", w.slot);
      r_.number("padr.reach.heard.delay", w.delay);
      r_.flag("padr.reach.heard.carried", w.carried);
    }
    for (const Endpoint& e : m.at) {
      r_.address("padr.reach.at.address", e);
      r_.number("padr.reach.at.port", e.port);
    }
  }
  void operator()(const wire::Newcomer& m) const {
    r_.address("padr.newcomer.address", m.at);
    r_.number("padr.newcomer.port", m.at.port);
  }

 private:
  void seats(const std::vector<wire::Seat>& all, const SeatNames& names) const {
    for (const wire::Seat& s : all) {
      r_.number(names.slot, s.slot);
      r_.number(names.incarnation, s.incarnation);
      r_.number(names.have, s.have);
      r_.number(names.heard, s.heard);
    }
  }

  Record& r_;
  Bytes payload_;
};

}  // namespace

bool put_state(Record& r, const wire::Opened& o, std::string_view& why) {
  const auto packet = wire::decode_state(o.payload, o.header.sender);
  if (!packet) return false;
  why = drop_of(packet->updates);
  if (!why.empty()) return false;
  const sync::StatePacket& p = *packet;
  r.number("padr.seq", p.seq);
  r.number("padr.tick", static_cast<std::uint64_t>(p.mark_tick));
  r.number("padr.mark_count", p.mark_count);
  r.number("padr.have", p.have);
  r.hex32("padr.have_beyond", p.have_beyond);
  r.number("padr.seen_seq", p.seen_seq);
  r.number("padr.seen_age", p.seen_age);
  r.signed_number("padr.transit", p.transit);
  r.number("padr.loss", p.loss);
  if (p.check_tick >= 0) {
    r.number("padr.check_age", static_cast<std::uint64_t>(p.mark_tick - p.check_tick));
    r.number("padr.check_tick", static_cast<std::uint64_t>(p.check_tick));
    r.hex32("padr.check_hash", p.check_hash);
  }
  r.number("padr.incarnation", p.incarnation);
  r.number("padr.to_incarnation", p.to_incarnation);
  r.flag("padr.mark", p.updates.empty());
  r.number("padr.updates", p.updates.size());
  r.number("padr.bodies", bodies_in(p.updates));
  for (const sync::Bundle& b : p.updates) put_update(r, b, p.mark_tick, p.mark_count);
  return true;
}

bool put_session(Record& r, const wire::Opened& o) {
  const auto message = wire::decode_session(o.payload);
  if (!message) return false;
  r.text("padr.message", name_of(*message));
  std::visit(SessionFields(r, o.payload), *message);
  return true;
}

bool put_membership(Record& r, const wire::Opened& o) {
  const auto message = wire::decode_membership(o.payload);
  if (!message) return false;
  r.text("padr.message", name_of(*message));
  std::visit(MembershipFields(r, o.payload), *message);
  return true;
}

}  // namespace padr::capture
