#include "tests/wire/listing.h"

#include <cinttypes>

#include <array>
#include <cstdio>

namespace padr::test {
namespace {

using sync::BodyUpdate;
using sync::Bundle;

template <typename... Args>
std::string line(const char* pattern, Args... args) {
  std::array<char, 200> text{};
  const int n = std::snprintf(text.data(), text.size(), pattern, args...);
  return {text.data(), static_cast<std::size_t>(n)};
}

constexpr std::array<const char*, 4> kModels{"static", "first", "second", "input"};

std::string number(float v) {
  return line("%.9g", static_cast<double>(v));
}
std::string pair(Vec2 v) {
  return number(v.x) + " " + number(v.y);
}
int flag(bool v) {
  return v ? 1 : 0;
}
unsigned long long ull(std::uint64_t v) {
  return v;
}
long long ll(std::int64_t v) {
  return v;
}

std::string bytes_of(const wire::Bytes& bytes) {
  std::string s;
  for (const std::byte b : bytes) s += line("%02x", std::to_integer<unsigned>(b));
  return s;
}
std::string address_of(const Endpoint& e) {
  std::string s;
  for (const std::uint8_t b : e.address) s += line("%02x", unsigned{b});
  if (e.has_key())
    for (const std::uint8_t b : e.key) s += line("%02x", unsigned{b});
  return s;
}

std::string list(const std::string& at, const Bundle& b);

std::string avatar_lines(const std::string& at, const sync::AvatarUpdate& a) {
  std::string s = at + ".cause = " + std::string(sync::kCauseNames[static_cast<std::size_t>(a.cause)]) + "\n";
  s += at + ".model = " + kModels[static_cast<std::size_t>(a.model)] + "\n";
  s += at + line(".awake = %d\n", flag(a.awake));
  s += at + ".position = " + pair(a.position) + "\n" + at + ".velocity = " + pair(a.velocity) + "\n";
  if (a.model >= Model::kSecond) s += at + ".control = " + pair(a.control) + "\n";
  return s;
}

std::string body_lines(const std::string& at, const BodyUpdate& u) {
  std::string s = at + ".cause = " + std::string(sync::kCauseNames[static_cast<std::size_t>(u.cause)]) + "\n";
  s += at + line(".held = %d\n", flag(u.held)) + at + line(".release = %d\n", flag(u.release));
  if (!u.has_state) return s;
  s += at + line(".epoch = %u\n", u.epoch) + at + line(".claimed = %d\n", u.claimed);
  s += at + line(".awake = %d\n", flag(u.state.awake)) + at + ".position = " + pair(u.state.position) + "\n";
  s += at + ".angle = " + number(u.state.angle) + "\n";
  if (!u.state.awake) return s;
  return s + at + ".velocity = " + pair(u.state.velocity) + "\n" + at + ".spin = " + number(u.state.spin) + "\n";
}

std::string order_lines(const std::string& at, const Bundle& b) {
  std::string s;
  if (b.admission) {
    const sync::Admission& a = *b.admission;
    const std::string o = at + ".admission";
    s += o + line(".slot = %d\n", int{a.slot}) + o + line(".incarnation = %u\n", a.incarnation);
    s += o + line(".first = %u\n", a.first) + o + ".address = " + address_of(a.at) + "\n";
    s += o + line(".port = %d\n", int{a.at.port});
    for (std::size_t p = 0; p < a.have.size(); ++p) s += o + line(".have[%zu] = %u\n", p, a.have[p]);
    if (a.spectator) s += o + ".spectator = 1\n";
  }
  for (const sync::Removal& r : b.removals)
    s += at + line(".removal[%d] = %u %u\n", int{r.slot}, r.incarnation, r.count);
  if (b.signature) {
    s += at + ".signature = ";
    for (const std::byte byte : *b.signature) s += line("%02x", std::to_integer<unsigned>(byte));
    s += "\n";
  }
  for (const Bundle& lost : b.passed_on) {
    const std::string o = at + ".passed_on";
    s += o + line(".slot = %d\n", int{lost.peer}) + list(o, lost);
  }
  return s;
}

std::string list(const std::string& at, const Bundle& b) {
  std::string s = at + line(".index = %u\n", b.index) + at + line(".tick = %d\n", b.tick);
  if (b.leave) s += at + ".leave = 1\n";
  if (b.spectates) s += at + ".spectates = 1\n";
  if (b.avatar) s += avatar_lines(at + ".avatar", *b.avatar);
  for (const BodyUpdate& u : b.bodies) s += body_lines(at + line(".body[%d]", int{u.body}), u);
  return s + order_lines(at, b);
}

std::string seats(const char* name, const std::vector<wire::Seat>& from) {
  std::string s;
  for (std::size_t i = 0; i < from.size(); ++i)
    s += line("%s[%zu] = %d %u %u %u\n", name, i, int{from[i].slot}, from[i].incarnation, from[i].have, from[i].heard);
  return s;
}

struct MembershipLister {
  std::string operator()(const wire::Pull& m) const {
    return line("pull.nonce = %llu\npull.from = %u\npull.wanted = %llu\npull.cookie = %llu\n", ull(m.nonce), m.from,
                ull(m.wanted), ull(m.cookie));
  }
  std::string operator()(const wire::Piece& m) const {
    return line("piece.nonce = %llu\npiece.index = %u\npiece.count = %u\n", ull(m.nonce), m.index, m.count) +
           "piece.bytes = " + bytes_of(m.bytes) + "\n";
  }
  std::string operator()(const wire::Enter& m) const { return line("enter.nonce = %llu\n", ull(m.nonce)); }
  std::string operator()(const wire::Poll& m) const {
    return seats("poll.lost", m.lost) + line("poll.freeze = %d\npoll.number = %u\n", flag(m.freeze), m.number);
  }
  std::string operator()(const wire::Answer& m) const {
    return seats("answer.lost", m.lost) +
           line("answer.frozen = %d\nanswer.tick = %d\nanswer.number = %u\n", flag(m.frozen), m.tick, m.number);
  }
  std::string operator()(const wire::Fetch& m) const {
    return line("fetch.slot = %d\nfetch.incarnation = %u\nfetch.from = %u\n", int{m.slot}, m.incarnation, m.from);
  }
  std::string operator()(const wire::Fetched& m) const {
    std::string s = line("fetched.slot = %d\nfetched.incarnation = %u\n", int{m.slot}, m.incarnation);
    for (std::size_t i = 0; i < m.updates.size(); ++i) s += list(line("fetched.update[%zu]", i), m.updates[i]);
    return s;
  }
  std::string operator()(const wire::Probe& m) const {
    return line("probe.incarnation = %u\n", m.incarnation) + seats("probe.member", m.members) +
           line("probe.knows_you = %d\nprobe.newest = %u\nprobe.yields = %d\n", flag(m.knows_you), m.newest,
                flag(m.yields));
  }
  std::string operator()(const wire::Reach& m) const {
    std::string s = line("reach.tick = %d\n", m.tick);
    for (std::size_t i = 0; i < m.heard.size(); ++i)
      s += line("reach.heard[%zu] = %d %u %d\n", i, int{m.heard[i].slot}, m.heard[i].delay, flag(m.heard[i].carried));
    for (std::size_t i = 0; i < m.at.size(); ++i)
      s += line("reach.at[%zu] = ", i) + address_of(m.at[i]) + line(" %d\n", int{m.at[i].port});
    return s;
  }
  std::string operator()(const wire::Newcomer& m) const {
    return "newcomer.address = " + address_of(m.at) + line("\nnewcomer.port = %d\n", int{m.at.port});
  }
};

struct SessionLister {
  std::string operator()(const wire::Join& m) const {
    return line("join.nonce = %llu\njoin.scene_hash = %llu\n", ull(m.nonce), ull(m.scene_hash)) +
           line("join.fingerprint = %llu\njoin.authority = %d\n", ull(m.fingerprint), flag(m.authority)) +
           "join.scenario = " + m.scenario + line("\njoin.spectator = %d\n", flag(m.spectator));
  }
  std::string operator()(const wire::Welcome& m) const {
    return line("welcome.nonce = %llu\nwelcome.peer = %d\n", ull(m.nonce), int{m.peer}) +
           line("welcome.slots = %d\nwelcome.wanted = %d\n", m.slots, m.wanted) +
           line("welcome.incarnation = %u\nwelcome.cookie = %llu\n", m.incarnation, ull(m.cookie)) + session_of(m);
  }
  static std::string session_of(const wire::Welcome& m) {
    std::string s;
    if (m.session == SessionId{}) return s;
    for (const std::uint8_t b : m.session) s += line("%02x", b);
    return "welcome.session = " + s + "\n";
  }
  std::string operator()(const wire::Redirect& m) const {
    return line("redirect.nonce = %llu\n", ull(m.nonce)) + "redirect.address = " + address_of(m.to) +
           line("\nredirect.port = %d\n", int{m.to.port});
  }
  std::string operator()(const wire::Refuse& m) const {
    return line("refuse.nonce = %llu\n", ull(m.nonce)) + "refuse.reason = " + m.reason + "\n";
  }
  std::string operator()(const wire::Ping& m) const { return line("ping.sent_us = %lld\n", ll(m.sent)); }
  std::string operator()(const wire::Pong& m) const {
    return line("pong.sent_us = %lld\npong.session_us = %lld\n", ll(m.sent), ll(m.session));
  }
  std::string operator()(const wire::Ask& m) const {
    return line("ask.nonce = %llu\nask.crowd = %llu\nask.about = %u\n", ull(m.nonce), ull(m.crowd), m.about) +
           "ask.in =" + regions(m.sender.in) + "\nask.seeks =" + regions(m.sender.seeks) +
           line("\nask.rank = %u\n", m.rank);
  }
  std::string operator()(const wire::Tell& m) const {
    std::string s = line("tell.nonce = %llu\ntell.crowd = %llu\n", ull(m.nonce), ull(m.crowd)) +
                    line("tell.about = %u\n", m.about) + "tell.in =" + regions(m.sender.in) +
                    "\ntell.seeks =" + regions(m.sender.seeks) +
                    line("\ntell.rank = %u\ntell.clock_us = %lld\n", m.rank, ll(m.clock));
    for (std::size_t i = 0; i < m.known.size(); ++i) {
      const wire::Acquaintance& k = m.known[i];
      s += line("tell.known[%zu] = ", i) + address_of(k.at) + line(" %d in", int{k.at.port}) + regions(k.where.in) +
           " seeks" + regions(k.where.seeks) + "\n";
    }
    return s + line("tell.noted = %d\n", flag(m.noted));
  }

 private:
  static std::string regions(const std::vector<std::uint32_t>& all) {
    std::string s;
    for (const std::uint32_t r : all) s += line(" %u", r);
    return s;
  }
};

std::string world_lines(const world::Snapshot& w) {
  std::string s;
  for (std::size_t e = 0; e < w.entities.size(); ++e) {
    const world::Kinematics& k = w.entities[e];
    s += line("transfer.entity[%zu] = ", e) + pair(k.position) + " " + number(k.angle) + " " + pair(k.velocity) + " " +
         number(k.spin) + " " + number(k.sleep_time) + line(" %d\n", flag(k.awake));
  }
  for (std::size_t i = 0; i < w.contacts.size(); ++i) {
    const world::ContactState& c = w.contacts[i];
    const std::string at = line("transfer.contact[%zu]", i);
    s += at + line(" = %u %u %d ", c.key, unsigned{c.type}, flag(c.touching)) + pair(c.local_normal) + " " +
         pair(c.local_point) + "\n";
    for (std::size_t p = 0; p < c.count; ++p)
      s += at + line(".point[%zu] = ", p) + pair(c.points[p].local) + " " + number(c.points[p].normal_impulse) + " " +
           number(c.points[p].tangent_impulse) + line(" %u\n", c.points[p].id);
  }
  return s;
}

std::string place_lines(const sync::Transfer& t, std::size_t p) {
  const sync::AvatarModel& a = t.state.avatars[p];
  std::string s = line("transfer.avatar[%zu] = %d %u ", p, flag(a.present), t.state.members[p].incarnation) +
                  kModels[static_cast<std::size_t>(a.kind)] + " " + pair(a.velocity) + " " + pair(a.control) +
                  line(" %d %d\n", a.since, flag(a.at_rest));
  s += line("transfer.slot[%zu] = %u %u", p, t.slots[p].first, t.have[p]);
  if (t.slots[p].at.is_set()) s += " " + address_of(t.slots[p].at) + line(" %d", int{t.slots[p].at.port});
  s += line(" %d", t.slots[p].since);
  return s + "\n";
}

}  // namespace

std::string list(const wire::Header& h) {
  return line("kind = %u\nsender = %u\nsession = %u\n", static_cast<unsigned>(h.kind), unsigned{h.sender},
              unsigned{h.session});
}

std::string list(const sync::StatePacket& p) {
  std::string s = line("seq = %u\nmark_tick = %d\nmark_count = %u\n", p.seq, p.mark_tick, p.mark_count);
  s += line("have = %u\nhave_beyond = %u\nseen_seq = %u\nseen_age = %u\n", p.have, p.have_beyond, p.seen_seq,
            p.seen_age);
  s += line("transit = %d\nloss = %u\n", p.transit, p.loss);
  s += line("incarnation = %u\nto_incarnation = %u\n", p.incarnation, p.to_incarnation);
  if (p.check_tick >= 0) s += line("check_tick = %d\ncheck_hash = %u\n", p.check_tick, p.check_hash);
  for (std::size_t i = 0; i < p.updates.size(); ++i) s += list(line("update[%zu]", i), p.updates[i]);
  return s;
}

std::string list(const wire::SessionMessage& m) {
  return std::visit(SessionLister{}, m);
}

std::string list(const wire::MembershipMessage& m) {
  return std::visit(MembershipLister{}, m);
}

std::string list(const sync::Transfer& t) {
  std::string s = line("transfer.tick = %d\ntransfer.wanted = %d\n", t.state.tick, t.state.start.wanted) +
                  line("transfer.begin = %d\n", t.state.start.at) + world_lines(t.state.world);
  for (std::size_t p = 0; p < t.slots.size(); ++p) s += place_lines(t, p);
  for (std::size_t b = 0; b < t.state.authority.size(); ++b) {
    const sync::Authority& a = t.state.authority[b];
    const int owner = a.owner == kNoPeer ? 0 : a.owner + 1;
    s += line("transfer.body[%zu] = %d %d %u %d %" PRIu64 "\n", b, owner, flag(a.released), a.epoch, a.claimed,
              t.state.holds[b]);
  }
  for (std::size_t i = 0; i < t.tail.size(); ++i) {
    const std::string at = line("transfer.tail[%zu]", i);
    s += at + line(".slot = %d\n", int{t.tail[i].peer}) + list(at, t.tail[i]);
  }
  for (std::size_t i = 0; i < t.gone.size(); ++i)
    s += line("transfer.gone[%zu] = ", i) + address_of(t.gone[i].at) +
         line(" %d %d %d\n", int{t.gone[i].at.port}, t.gone[i].since, t.gone[i].removed);
  for (std::size_t i = 0; i < t.proofs.size(); ++i) {
    const std::string at = line("transfer.proof[%zu]", i);
    s += at + " = ";
    for (const std::uint8_t b : t.proofs[i].key) s += line("%02x", unsigned{b});
    s += line(" %u\n", t.proofs[i].incarnation);
    for (const auto& [name, b] : {std::pair(".one", &t.proofs[i].one), std::pair(".other", &t.proofs[i].other)})
      s += at + name + line(".slot = %d\n", int{b->peer}) + list(at + name, *b);
  }
  return s;
}

std::string hex(const wire::Bytes& bytes) {
  std::string s;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    s += line("%02x%s", std::to_integer<unsigned>(bytes[i]), i % 16 == 15 || i + 1 == bytes.size() ? "\n" : " ");
  return s;
}

Reading read(const wire::Bytes& datagram) {
  constexpr std::array<const char*, 7> kSealErrors{"none", "short", "long", "magic", "version", "kind", "tag"};
  wire::SealError error{};
  const auto opened = wire::open(datagram, error);
  if (!opened) return {line("drop = %s\n", kSealErrors[static_cast<std::size_t>(error)]), {}};
  const wire::Header& h = opened->header;
  if (h.kind == wire::Kind::kState) {
    if (const auto p = wire::decode_state(opened->payload, h.sender))
      return {list(h) + list(*p), wire::seal(h, wire::encode(*p))};
  } else if (h.kind == wire::Kind::kSession) {
    if (const auto m = wire::decode_session(opened->payload))
      return {list(h) + list(*m), wire::seal(h, wire::encode_session(*m))};
  } else if (const auto m = wire::decode_membership(opened->payload)) {
    return {list(h) + list(*m), wire::seal(h, wire::encode_membership(*m))};
  }
  return {"drop = malformed\n", {}};
}

}  // namespace padr::test
