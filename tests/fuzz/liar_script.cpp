#include "tests/fuzz/liar_script.h"

#include <algorithm>
#include <limits>

#include "common/wire/signature.h"

namespace padr::test {
namespace {

using sync::Bundle;
using sync::StatePacket;
using Values = std::array<std::uint8_t, LieEntry::kValues>;

constexpr std::uint32_t kStateKinds = 9;
constexpr std::uint32_t kKinds = LieEntry::kKinds;
/// Higher numbers have no form on the wire.
constexpr std::uint32_t kLastIndex = std::numeric_limits<std::uint32_t>::max() - 1;

/// A number at, near or far from an honest one.
std::uint32_t number(std::uint32_t honest, std::uint8_t how, std::uint8_t by) {
  switch (how % 9) {
    case 0:
    case 1:
      return honest;
    case 2:
      return honest + by;
    case 3:
      return honest - std::min<std::uint32_t>(honest, by);
    case 4:
      return honest + (std::uint32_t{by} << 8U);
    case 5:
      return by;
    case 6:
      return (1U << 30U) - 1 + by % 3U;
    case 7:
      return std::numeric_limits<std::uint32_t>::max();
    default:
      return std::uint32_t{by} << (how / 9U);
  }
}

Tick tick(Tick honest, std::uint8_t how, std::uint8_t by) {
  const std::uint32_t t = number(static_cast<std::uint32_t>(std::max(0, honest)), how, by);
  return static_cast<Tick>(std::min<std::uint32_t>(t, std::numeric_limits<Tick>::max() - 1));
}

float real(float honest, std::uint8_t how) {
  constexpr std::array kWrong{std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::denorm_min(),
                              1e6F,
                              -1e6F,
                              121.5F,
                              -0.0F};
  if (how < kWrong.size()) return kWrong[how];
  return how % 2 == 0 ? honest : honest + (static_cast<float>(how) - 128) / 16;
}

Endpoint place(const LiarsKnowledge& with, std::uint8_t how) {
  const auto& seats = with.replica.roster().seats;
  if (how % 2 == 0) return seats[how / 2 % seats.size()].at;
  Endpoint at = ipv4({10, 0, 0, how}, static_cast<std::uint16_t>(how % 8 == 1 ? 0 : 7000));
  if (how % 4 == 1) at.key.fill(how);
  return at;
}

PeerId slot(const LiarsKnowledge& with, std::uint8_t how) {
  return how >= 250 ? static_cast<PeerId>(how) : static_cast<PeerId>(how % with.replica.roster().seats.size());
}

std::uint32_t incarnation_of(const LiarsKnowledge& with, PeerId p) {
  const node::Roster& r = with.replica.roster();
  if (p >= r.seats.size()) return 0;
  return p == r.self ? r.incarnation : r.seats[p].incarnation;
}

std::uint32_t have(const LiarsKnowledge& with, PeerId p) {
  return p < with.replica.roster().seats.size() ? with.replica.agreed().log().have(p) : 0;
}

void sign(Bundle& b, const LiarsKnowledge& with) {
  const node::ReplicaConfig& c = with.replica.config();
  b.signature = wire::sign_update(with.key, {c.session_id, c.incarnation}, b);
}

void change_avatar(Bundle& b, const Values& v) {
  if (!b.avatar) b.avatar = sync::AvatarUpdate{};
  sync::AvatarUpdate& a = *b.avatar;
  a.position = {real(a.position.x, v[1]), real(a.position.y, v[2])};
  a.velocity = {real(a.velocity.x, v[3]), real(a.velocity.y, v[4])};
  a.control = {real(a.control.x, v[5]), real(a.control.y, v[6])};
  a.awake = v[7] % 4 != 0;
  a.model = static_cast<Model>(v[8] % 4);
}

void change_bodies(Bundle& b, const LiarsKnowledge& with, const Values& v) {
  sync::BodyUpdate u;
  const auto& authority = with.replica.agreed().confirmed().authority;
  u.body = v[1] == 255 ? EntityId{5000} : static_cast<EntityId>(v[1] % authority.size());
  u.held = (v[2] & 1U) != 0;
  u.has_state = (v[2] & 6U) != 0;
  u.release = (v[2] & 8U) != 0;
  u.state.awake = u.has_state && (v[2] & 48U) != 0;
  u.epoch = number(u.body < authority.size() ? authority[u.body].epoch + 1 : 1, v[3], v[4]);
  u.claimed = std::max(0, b.tick - static_cast<Tick>(v[5] / 8));
  u.state.position = {real(5, v[6]), real(5, v[7])};
  if (u.state.awake) u.state.velocity = {real(0, v[8]), 0};
  std::erase_if(b.bodies, [&u](const sync::BodyUpdate& other) { return other.body == u.body; });
  if (b.bodies.size() >= sync::kMaxBodiesPerSigned) b.bodies.pop_back();
  b.bodies.push_back(u);
  std::sort(b.bodies.begin(), b.bodies.end(), [](const auto& x, const auto& y) { return x.body < y.body; });
}

sync::Admission admission(const LiarsKnowledge& with, const Values& v) {
  sync::Admission a;
  a.slot = slot(with, v[1]);
  a.incarnation = number(with.replica.roster().newest_incarnation() + 1, v[2], v[3]);
  a.first = number(have(with, a.slot), v[4], v[5]);
  a.at = place(with, v[6]);
  a.spectator = v[3] % 4 == 3;
  const std::size_t slots = with.replica.roster().seats.size() - (v[7] == 255 ? 1 : 0);
  for (PeerId p = 0; p < slots; ++p) a.have.push_back(number(have(with, p), p % 2 == 0 ? v[7] : 0, v[8]));
  return a;
}

std::vector<sync::Removal> removals(const LiarsKnowledge& with, const Values& v) {
  std::vector<sync::Removal> all;
  for (PeerId p = 0; p < with.replica.roster().seats.size(); ++p)
    if ((v[1] >> p & 1U) != 0 && p != with.replica.self())
      all.push_back({p, number(incarnation_of(with, p), v[2], v[3]), number(have(with, p), v[4], v[5])});
  return all;
}

/// Somebody's update, as it is known or not.
Bundle of_another(const LiarsKnowledge& with, const Values& v, Tick before) {
  const PeerId whose = slot(with, v[1]);
  const std::vector<Bundle> known =
      whose < with.replica.roster().seats.size() ? with.replica.agreed().log().of(whose, 0) : std::vector<Bundle>{};
  Bundle b;
  if (!known.empty()) b = known[v[2] % known.size()];
  b.passed_on.clear();
  b.peer = whose;
  if (v[3] % 2 == 0) {
    b.index = std::min(kLastIndex, number(have(with, whose), v[4], v[5]));
    b.tick = std::min(before, tick(before, v[6], v[7]));
  }
  if (v[8] % 4 == 1) change_avatar(b, v);
  if (v[8] % 4 == 2) b.removals = removals(with, v);
  if (v[8] % 4 == 3) sign(b, with);
  return b;
}

void change_link(StatePacket& p, const LiarsKnowledge& with, const Values& v) {
  switch (v[0] % 11) {
    case 0:
      p.seq = number(p.seq, v[1], v[2]);
      break;
    case 1:
      p.incarnation = number(p.incarnation, v[1], v[2]);
      break;
    case 2:
      p.to_incarnation = number(p.to_incarnation, v[1], v[2]);
      break;
    case 3:
      p.mark_tick = tick(p.mark_tick, v[1], v[2]);
      break;
    case 4:
      p.mark_count = number(p.mark_count, v[1], v[2]);
      break;
    case 5:
      p.have = number(p.have, v[1], v[2]);
      p.have_beyond = number(p.have_beyond, v[3], v[4]);
      break;
    case 6:
      p.seen_seq = number(p.seen_seq, v[1], v[2]);
      p.seen_age = number(p.seen_age, v[3], v[4]);
      break;
    case 7:
      p.transit = static_cast<std::int32_t>(number(0, v[1], v[2]));
      p.loss = v[3];
      break;
    case 8:
      p.updates.clear();
      break;
    default:
      p.check_tick = tick(with.replica.agreed().confirmed().tick / 30 * 30, v[1], v[2]);
      p.check_hash = number(p.check_hash, v[3], v[4]);
  }
}

/// The update that is changed: the newest of the packet, or a new one.
Bundle& update_of(StatePacket& p, PeerId self) {
  if (!p.updates.empty()) return p.updates.back();
  Bundle& b = p.updates.emplace_back();
  b.peer = self;
  b.index = std::min(kLastIndex, p.mark_count++);
  b.tick = p.mark_tick;
  return b;
}

Bundle emptied(const Bundle& b) {
  Bundle e;
  e.peer = b.peer;
  e.index = b.index;
  e.tick = b.tick;
  return e;
}

void change_update(Bundle& b, const LieEntry& e, const LiarsKnowledge& with) {
  const std::uint32_t kind = e.what % kKinds;
  if (kind >= 4 && kind <= 6) b = emptied(b);
  if (kind == 1) change_avatar(b, e.v);
  if (kind == 2) change_bodies(b, with, e.v);
  if (kind == 3) (e.v[0] % 4 == 1 ? b.spectates : b.leave) = e.v[0] % 4 != 3;
  if (kind == 4) b.admission = admission(with, e.v);
  if (kind == 5) b.removals = removals(with, e.v);
  if (kind == 6) b.passed_on = {of_another(with, e.v, b.tick - 1)};
  if (kind == 7) {
    b.index = std::min(kLastIndex, number(b.index, e.v[1], e.v[2]));
    b.tick = tick(b.tick, e.v[3], e.v[4]);
  }
  if (e.what % kKinds == 8)
    b.signature.emplace().fill(std::byte{e.v[1]});
  else
    sign(b, with);
}

/// The marks must not be behind the updates, or they have no form on the wire.
void make_writable(StatePacket& p) {
  for (const Bundle& b : p.updates) {
    p.mark_count = std::max(p.mark_count, b.index + 1);
    p.mark_tick = std::max(p.mark_tick, b.tick);
  }
}

std::vector<wire::Seat> seats(const LiarsKnowledge& with, const Values& v) {
  std::vector<wire::Seat> all;
  for (PeerId p = 0; p < with.replica.roster().seats.size(); ++p)
    if ((v[0] >> p & 1U) != 0)
      all.push_back({p, number(incarnation_of(with, p), v[1], v[2]), number(have(with, p), v[3], v[4]),
                     std::min<std::uint32_t>(v[5], wire::kMostHeard)});
  if (all.empty()) all.push_back({slot(with, v[0]), v[1], v[2], 0});
  return all;
}

wire::MembershipMessage membership(const LieEntry& e, const LiarsKnowledge& with) {
  const Values& v = e.v;
  const PeerId about = slot(with, v[1]);
  switch (e.what % kKinds) {
    case 9:
    case 10:
      return wire::Poll{seats(with, v), v[6] % 4 != 0, number(0, v[7], v[8]) % (wire::kMostPollNumber + 2)};
    case 11:
    case 12:
      return wire::Answer{seats(with, v), v[6] % 2 == 0, tick(with.replica.now(), v[7], v[8]), v[6] / 16U};
    case 13:
    case 14:
      return wire::Fetch{about, number(incarnation_of(with, about), v[2], v[3]), number(have(with, about), v[4], v[5])};
    case 15:
    case 16:
      return wire::Fetched{about, incarnation_of(with, about), {of_another(with, v, with.replica.now())}};
    case 17:
    case 18:
      return wire::Probe{number(with.replica.roster().incarnation, v[7] % 3 == 0 ? v[7] : 0, v[8]), seats(with, v),
                         v[6] % 2 == 0, number(with.replica.roster().newest_incarnation(), v[7], v[8])};
    case 19:
      return wire::Pull{1U + v[0], v[1], std::uint64_t{v[2]} * 0x0101010101010101U, 1U + v[3]};
    case 20:
      return wire::Piece{1U + v[0], v[1] % 4U, 1U + v[2] % 4U, wire::Bytes(1U + v[3], std::byte{v[4]})};
    case 21: {
      wire::Reach reach{tick(with.replica.now(), v[7], v[8]), {}};
      for (const wire::Seat& s : seats(with, v)) reach.heard.push_back({s.slot, v[6], s.slot % 2 == v[5] % 2U});
      if (v[4] % 2 == 0) reach.at.assign(v[4] % 3U, place(with, v[3]).place());
      return reach;
    }
    default:
      if (v[1] % 2 == 0) return wire::Newcomer{place(with, v[2])};
      return wire::Enter{1U + v[0]};
  }
}

wire::SessionMessage session(const LieEntry& e, const LiarsKnowledge& with) {
  const Values& v = e.v;
  const std::uint64_t nonce = 1U + v[1];
  switch (v[0] % 8) {
    case 0:
      return wire::Join{nonce, 0, 0, v[2] % 2 == 0, "x"};
    case 1:
      return wire::Welcome{
          nonce, slot(with, v[2]), v[3] % 64, v[4] % 64, v[5], 1U + v[6], with.replica.config().session_id};
    case 2:
      return wire::Redirect{nonce, place(with, v[2])};
    case 3:
      return wire::Refuse{v[1], "no"};
    case 4:
      return wire::Ping{static_cast<Micros>(number(0, v[2], v[3]))};
    case 5:
      return wire::Pong{static_cast<Micros>(number(0, v[2], v[3])), static_cast<Micros>(number(0, v[4], v[5]))};
    case 6:
      return wire::Ask{nonce, v[2], 1U + v[3], {}, v[4]};
    default:
      return wire::Tell{nonce, v[2], 1U + v[3], {}, v[4], v[5]};
  }
}

}  // namespace

std::vector<LieEntry> lie_script(std::span<const std::uint8_t> bytes, std::size_t most) {
  std::vector<LieEntry> script;
  for (; bytes.size() >= LieEntry::kBytes && script.size() < most; bytes = bytes.subspan(LieEntry::kBytes)) {
    LieEntry& e = script.emplace_back(LieEntry{bytes[0], bytes[1], bytes[2], {}});
    std::copy_n(bytes.begin() + 3, LieEntry::kValues, e.v.begin());
  }
  return script;
}

bool is_of_state(const LieEntry& e) {
  return e.what % kKinds < kStateKinds;
}

void lie(StatePacket& p, const LieEntry& e, const LiarsKnowledge& with) {
  if (e.what % kKinds == 0)
    change_link(p, with, e.v);
  else
    change_update(update_of(p, with.replica.self()), e, with);
  make_writable(p);
}

std::optional<wire::Bytes> lie(const LieEntry& e, const LiarsKnowledge& with) {
  const node::ReplicaConfig& c = with.replica.config();
  const bool joins = e.what % kKinds == kKinds - 1;
  const wire::Bytes payload =
      joins ? wire::encode_session(session(e, with)) : wire::encode_membership(membership(e, with));
  if (payload.size() > wire::kMaxPayload) return std::nullopt;
  return wire::seal({joins ? wire::Kind::kSession : wire::Kind::kMembership, c.self, c.session}, payload);
}

}  // namespace padr::test
