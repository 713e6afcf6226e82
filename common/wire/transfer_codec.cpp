#include "common/wire/transfer_codec.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "common/sync/validation.h"
#include "common/wire/endpoint_codec.h"
#include "common/wire/passage_codec.h"
#include "common/wire/update_codec.h"
#include "proto/wire.pb.h"

namespace padr::wire {
namespace {

using sync::FoldState;
using Message = padr::wire::Transfer;

constexpr int kEntityNumbers = 7;
constexpr int kPointNumbers = 4;
constexpr char kAsleep = '\0';
constexpr char kAwake = '\1';
constexpr unsigned kLastManifoldType = 2;
// Of a contact's memory: Box2D aborts on impulses that pull, and must not overflow. Far above what any scene has.
constexpr float kMostNormal = 1.01F;    ///< each coordinate of a unit vector, or 0
constexpr float kMostLocal = 1.0e4F;    ///< m
constexpr float kMostImpulse = 1.0e9F;  ///< N s

void put_world(const world::Snapshot& s, Message& out) {
  for (const world::Kinematics& k : s.entities) {
    for (const float v : {k.position.x, k.position.y, k.angle, k.velocity.x, k.velocity.y, k.spin, k.sleep_time})
      out.add_entities(v);
    out.mutable_awake()->push_back(k.awake ? kAwake : kAsleep);
  }
  for (const world::ContactState& c : s.contacts) {
    Message::Contact& to = *out.add_contacts();
    to.set_key(c.key);
    to.set_type(c.type);
    to.set_touching(c.touching);
    for (const float v : {c.local_normal.x, c.local_normal.y, c.local_point.x, c.local_point.y}) to.add_numbers(v);
    for (std::size_t i = 0; i < c.count; ++i) {
      const world::ContactState::Point& p = c.points[i];
      for (const float v : {p.local.x, p.local.y, p.normal_impulse, p.tangent_impulse}) to.add_numbers(v);
      to.add_ids(p.id);
    }
  }
}

void put_avatars(const FoldState& s, Message& out) {
  for (std::size_t p = 0; p < s.avatars.size(); ++p) {
    const sync::AvatarModel& m = s.avatars[p];
    Message::Avatar& to = *out.add_avatars();
    to.set_present(m.present);
    to.set_incarnation(s.members[p].incarnation);
    to.set_member(s.members[p].present);
    to.set_model(static_cast<unsigned>(m.kind));
    for (const float v : {m.velocity.x, m.velocity.y, m.control.x, m.control.y}) to.add_numbers(v);
    to.set_since(static_cast<std::uint32_t>(m.since));
    to.set_at_rest(m.at_rest);
    to.set_going(s.members[p].going);
  }
}

void put_authority(const FoldState& s, Message& out) {
  for (const sync::Authority& a : s.authority) {
    Message::Authority& to = *out.add_authority();
    to.set_owner(a.owner == kNoPeer ? 0 : a.owner + 1U);
    to.set_released(a.released);
    to.set_epoch(a.epoch);
    to.set_claimed(static_cast<std::uint32_t>(a.claimed));
  }
  for (const PeerSet h : s.holds) out.add_holds(h);
}

void put_passed_on(const sync::Bundle& b, PassedOn& to) {
  to.set_slot(b.peer);
  to.set_index(b.index);
  to.set_tick(static_cast<std::uint32_t>(b.tick));
  put_update(b, b.tick, b.index + 1, *to.mutable_update());
}

std::string passed_on_bytes(const sync::Bundle& b) {
  PassedOn to;
  put_passed_on(b, to);
  return to.SerializeAsString();
}

constexpr auto kMaxTick = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
// Numbers that grow by one at a time, as in sync::admit.
constexpr std::uint32_t kMost = 1U << 30U;

bool within(Vec2 v, float most) {
  return is_finite(v) && std::abs(v.x) <= most && std::abs(v.y) <= most;
}

bool is_usable(const world::ContactState& c) {
  for (std::size_t i = 0; i < c.count; ++i) {
    const world::ContactState::Point& p = c.points[i];
    const Vec2 impulse{p.normal_impulse, p.tangent_impulse};
    if (!within(p.local, kMostLocal) || !within(impulse, kMostImpulse) || impulse.x < 0) return false;
  }
  return within(c.local_normal, kMostNormal) && within(c.local_point, kMostLocal);
}

bool all_finite(const google::protobuf::RepeatedField<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/// Reads a message against the scene that it must be of. Whatever World or Fold would not have come to by itself is
/// refused: what is taken in has to come out again to the bit, or the confirmed worlds differ.
class Reader {
 public:
  Reader(const Message& in, const Scene& scene, int slots)
      : in_(in), scene_(scene), slots_(slots), bodies_(static_cast<int>(scene.bodies.size())) {}

  bool read(sync::Transfer& out) const {
    if (in_.tick() >= kMaxTick) return false;
    out.state.tick = static_cast<Tick>(in_.tick());
    return read_start(out.state) && read_entities(out.state.world) && read_contacts(out.state.world) &&
           read_avatars(out.state) && waits(out.state) && read_authority(out.state) &&
           take_residents(in_, scene_.region ? scene_.bodies.size() : 0, out.state.residents) && read_slots(out) &&
           read_tail(out) && read_gone(out) && read_proofs(out);
  }

 private:
  // A tick further ahead would let nobody play.
  bool read_start(FoldState& out) const {
    if (in_.wanted() > static_cast<unsigned>(slots_) || in_.begin() > in_.tick() + sync::kStartLead) return false;
    out.start = {static_cast<int>(in_.wanted()), static_cast<Tick>(in_.begin())};
    return in_.wanted() == 0 || in_.begin() == 0;
  }

  // For nobody once as many are there.
  static bool waits(const FoldState& s) {
    return s.start.wanted == 0 || std::count_if(s.avatars.begin(), s.avatars.end(),
                                                [](const sync::AvatarModel& m) { return m.present; }) < s.start.wanted;
  }

  bool read_entities(world::Snapshot& out) const {
    const int n = bodies_ + slots_;
    if (in_.entities_size() != n * kEntityNumbers || in_.awake().size() != static_cast<std::size_t>(n)) return false;
    for (int e = 0; e < n; ++e) {
      const auto v = [&](int i) { return in_.entities(e * kEntityNumbers + i); };
      const char awake = in_.awake()[static_cast<std::size_t>(e)];
      const world::Kinematics k{{v(0), v(1)}, v(2), {v(3), v(4)}, v(5), v(6), awake == kAwake};
      if (awake != kAwake && awake != kAsleep) return false;
      if (!sync::believable({k.position, k.angle, k.velocity, k.spin, k.awake}, scene_)) return false;
      if (!std::isfinite(k.sleep_time) || k.sleep_time < 0) return false;
      const bool still = k.velocity == Vec2{} && k.spin == 0 && k.sleep_time == 0;
      if (!k.awake && !still) return false;
      out.entities.push_back(k);
    }
    return true;
  }

  bool read_contacts(world::Snapshot& out) const {
    for (const Message::Contact& c : in_.contacts()) {
      world::ContactState s;
      if (!read_contact(c, s) || (!out.contacts.empty() && out.contacts.back().key >= s.key)) return false;
      out.contacts.push_back(s);
    }
    return true;
  }

  bool read_contact(const Message::Contact& c, world::ContactState& out) const {
    const auto moving = static_cast<std::uint32_t>(bodies_ + slots_);
    const std::uint32_t first = c.key() >> 16U;
    const std::uint32_t second = c.key() & 0xFFFFU;
    if (first >= moving || second <= first || second >= moving + scene_.statics.size()) return false;
    const auto points = static_cast<std::size_t>(c.ids_size());
    if (points > out.points.size() || (points == 0 && !c.touching()) || c.type() > kLastManifoldType) return false;
    if (c.numbers_size() != 4 + kPointNumbers * c.ids_size()) return false;
    out.key = c.key();
    out.type = static_cast<std::uint8_t>(c.type());
    out.count = static_cast<std::uint8_t>(points);
    out.touching = c.touching();
    out.local_normal = {c.numbers(0), c.numbers(1)};
    out.local_point = {c.numbers(2), c.numbers(3)};
    for (std::size_t i = 0; i < points; ++i) {
      const auto v = [&](int k) { return c.numbers(4 + static_cast<int>(i) * kPointNumbers + k); };
      out.points[i] = {{v(0), v(1)}, v(2), v(3), c.ids(static_cast<int>(i))};
    }
    return is_usable(out);
  }

  bool read_avatars(FoldState& out) const {
    if (in_.avatars_size() != slots_) return false;
    const sync::AdmitLimits limits;
    for (const Message::Avatar& a : in_.avatars()) {
      if (a.numbers_size() != 4 || !all_finite(a.numbers())) return false;
      const Vec2 velocity{a.numbers(0), a.numbers(1)};
      const Vec2 control{a.numbers(2), a.numbers(3)};
      if (a.model() > static_cast<unsigned>(Model::kInput) || a.since() > in_.tick()) return false;
      const auto model = static_cast<Model>(a.model());
      if (length(velocity) > limits.max_speed || !sync::believable_control(model, control, scene_)) return false;
      // A spectator has no avatar, nor has whoever has come into a region before it has told where it is.
      if ((a.present() && !a.member()) || a.incarnation() >= kMost) return false;
      if (a.going() && !(scene_.region && a.member())) return false;
      out.members.push_back({a.member(), a.incarnation(), a.going()});
      out.avatars.push_back({a.present(), model, velocity, control, static_cast<Tick>(a.since()), a.at_rest()});
    }
    return true;
  }

  bool read_authority(FoldState& out) const {
    if (in_.authority_size() != bodies_ || in_.holds_size() != bodies_) return false;
    for (const Message::Authority& a : in_.authority()) {
      if (a.owner() > static_cast<std::uint32_t>(slots_) || a.claimed() > in_.tick() || a.epoch() > kMost) return false;
      // Never claimed: nobody's, with nothing on record.
      const bool blank = a.released() && a.epoch() == 0 && a.claimed() == 0;
      if (a.owner() == 0 ? !blank : a.epoch() == 0) return false;
      const PeerId owner = a.owner() == 0 ? kNoPeer : static_cast<PeerId>(a.owner() - 1);
      out.authority.push_back({owner, a.released(), a.epoch(), static_cast<Tick>(a.claimed())});
    }
    const PeerSet slots = ~PeerSet{0} >> static_cast<unsigned>(kMaxPeers - slots_);
    if (std::any_of(in_.holds().begin(), in_.holds().end(), [&](PeerSet h) { return (h & ~slots) != 0; })) return false;
    out.holds.assign(in_.holds().begin(), in_.holds().end());
    return true;
  }

  bool read_slots(sync::Transfer& out) const {
    if (in_.slots_size() != slots_) return false;
    for (const Message::Slot& s : in_.slots()) {
      sync::Transfer::Slot& to = out.slots.emplace_back();
      to.first = s.first();
      if (s.have() < s.first() || s.have() >= kMost) return false;
      out.have.push_back(s.have());
      if (s.address().empty() ? s.port() != 0 : !take_endpoint(s, to.at)) return false;
      if (s.since() >= kMaxTick) return false;
      to.since = static_cast<Tick>(s.since());
    }
    return true;
  }

  bool read_gone(sync::Transfer& out) const {
    if (static_cast<std::size_t>(in_.gone_size()) > sync::Transfer::kMostGone) return false;
    for (const Message::Place& g : in_.gone()) {
      sync::Transfer::Gone& to = out.gone.emplace_back();
      if (!take_endpoint(g, to.at) || g.since() > g.removed() || g.removed() >= kMaxTick) return false;
      to.since = static_cast<Tick>(g.since());
      to.removed = static_cast<Tick>(g.removed());
    }
    return true;
  }

  bool read_passed_on(const PassedOn& p, sync::Bundle& b) const {
    if (p.slot() >= static_cast<std::uint32_t>(slots_) || p.tick() >= kMaxTick || p.index() >= kMost) return false;
    b.peer = static_cast<PeerId>(p.slot());
    return take_update(p.update(), static_cast<Tick>(p.tick()), p.index() + 1, b);
  }

  bool read_proofs(sync::Transfer& out) const {
    if (static_cast<std::size_t>(in_.proofs_size()) > sync::Transfer::kMostProofs) return false;
    for (const Message::Proof& p : in_.proofs()) {
      sync::Transfer::Proof& to = out.proofs.emplace_back();
      if (p.key().size() != to.key.size() || p.incarnation() >= kMost) return false;
      std::copy(p.key().begin(), p.key().end(), to.key.begin());
      to.incarnation = p.incarnation();
      PassedOn one;
      PassedOn other;
      if (!one.ParseFromString(p.one()) || !other.ParseFromString(p.other())) return false;
      if (!read_passed_on(one, to.one) || !read_passed_on(other, to.other)) return false;
    }
    return true;
  }

  bool read_tail(sync::Transfer& out) const {
    for (const PassedOn& p : in_.tail()) {
      sync::Bundle b;
      if (!read_passed_on(p, b)) return false;
      if (b.tick < out.state.tick || sync::admit(b, scene_, slots_) != sync::DropReason::kNone) return false;
      if (!out.tail.empty() && std::tie(out.tail.back().tick, out.tail.back().peer) >= std::tie(b.tick, b.peer))
        return false;
      out.tail.push_back(std::move(b));
    }
    return true;
  }

  const Message& in_;
  const Scene& scene_;
  int slots_;
  int bodies_;
};

}  // namespace

Bytes encode_transfer(const sync::Transfer& t) {
  Message out;
  out.set_tick(static_cast<std::uint32_t>(t.state.tick));
  out.set_wanted(static_cast<std::uint32_t>(t.state.start.wanted));
  out.set_begin(static_cast<std::uint32_t>(t.state.start.at));
  put_world(t.state.world, out);
  put_avatars(t.state, out);
  put_authority(t.state, out);
  put_residents(t.state.residents, out);
  for (std::size_t p = 0; p < t.slots.size(); ++p) {
    Message::Slot& to = *out.add_slots();
    to.set_first(t.slots[p].first);
    to.set_have(t.have[p]);
    if (t.slots[p].at.is_set()) put_endpoint(t.slots[p].at, to);
    to.set_since(static_cast<std::uint32_t>(t.slots[p].since));
  }
  for (const sync::Bundle& b : t.tail) put_passed_on(b, *out.add_tail());
  for (const sync::Transfer::Gone& g : t.gone) {
    Message::Place& to = *out.add_gone();
    put_endpoint(g.at, to);
    to.set_since(static_cast<std::uint32_t>(g.since));
    to.set_removed(static_cast<std::uint32_t>(g.removed));
  }
  for (const sync::Transfer::Proof& p : t.proofs) {
    Message::Proof& to = *out.add_proofs();
    to.set_key(std::string(p.key.begin(), p.key.end()));
    to.set_incarnation(p.incarnation);
    to.set_one(passed_on_bytes(p.one));
    to.set_other(passed_on_bytes(p.other));
  }
  Bytes bytes(out.ByteSizeLong());
  out.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

std::optional<sync::Transfer> decode_transfer(std::span<const std::byte> bytes, const Scene& scene, int slots) {
  Message in;
  sync::Transfer out;
  if (!in.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return std::nullopt;
  if (!Reader(in, scene, slots).read(out)) return std::nullopt;
  return out;
}

}  // namespace padr::wire
