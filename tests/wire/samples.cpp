#include "tests/wire/samples.h"

#include <algorithm>

#include "common/model/precision.h"
#include "tests/world/test_scene.h"

namespace padr::test {
namespace {

using sync::BodyUpdate;
using sync::Bundle;

constexpr Tick kLogTicks = 400;
/// How late others' updates and marks are.
constexpr Tick kDelay = 20;
constexpr std::uint32_t kSome = 1U << 30U;

float any_float(Rng& rng) {
  return static_cast<float>(rng.uniform(-60, 60));
}
Vec2 any_vec(Rng& rng) {
  return {any_float(rng), any_float(rng)};
}
/// Of any length in bytes.
std::uint32_t any_count(Rng& rng) {
  return rng.below(kSome) >> rng.below(30);
}

Endpoint any_endpoint(Rng& rng) {
  Endpoint e;
  for (std::uint8_t& b : e.address) b = static_cast<std::uint8_t>(rng.below(256));
  if (rng.chance(0.5)) {
    std::fill_n(e.address.begin(), 10, std::uint8_t{0});
    e.address[10] = e.address[11] = 0xFF;
  }
  e.port = static_cast<std::uint16_t>(1 + rng.below(65535));
  if (rng.chance(0.3))
    for (std::uint8_t& b : e.key) b = static_cast<std::uint8_t>(rng.below(256));
  return e;
}

BodyUpdate any_body(Rng& rng, EntityId id, Tick tick) {
  BodyUpdate u;
  u.body = id;
  u.cause = static_cast<sync::Cause>(rng.below(sync::kCauses));
  u.held = rng.chance(0.5);
  u.release = rng.chance(0.3);
  u.has_state = rng.chance(0.7);
  if (!u.has_state) return u;
  u.epoch = 1 + any_count(rng);
  u.claimed = static_cast<Tick>(rng.below(static_cast<std::uint32_t>(tick) + 1));
  u.state = {any_vec(rng), any_float(rng), any_vec(rng), any_float(rng), rng.chance(0.7)};
  if (!u.state.awake) {
    u.state.velocity = {};
    u.state.spin = 0;
  }
  return u;
}

/// As a peer tells them by default.
void round_states(Bundle& b) {
  for (BodyUpdate& u : b.bodies)
    if (u.has_state) u.state = rounded(u.state);
  if (!b.avatar) return;
  b.avatar->position = rounded_place(b.avatar->position);
  b.avatar->velocity = rounded_motion(b.avatar->velocity);
  b.avatar->control = rounded_place(b.avatar->control);
}

void tell_entities(Rng& rng, Bundle& b) {
  if (rng.chance(0.7)) {
    sync::AvatarUpdate a;
    a.cause = static_cast<sync::Cause>(rng.below(sync::kCauses));
    a.model = static_cast<Model>(rng.below(4));
    a.position = any_vec(rng);
    a.awake = rng.chance(0.8);
    if (a.awake) a.velocity = any_vec(rng);
    if (a.model == Model::kSecond || a.model == Model::kInput) a.control = any_vec(rng);
    b.avatar = a;
  }
  for (EntityId id = 0; id < 40 && b.bodies.size() < 6; ++id)
    if (rng.chance(0.15)) b.bodies.push_back(any_body(rng, id, b.tick));
  if (rng.chance(0.5)) round_states(b);
}

PeerId other_than(Rng& rng, PeerId peer) {
  return static_cast<PeerId>((peer + 1 + rng.below(kMaxPeers - 1)) % kMaxPeers);
}

sync::Admission any_admission(Rng& rng, PeerId by) {
  sync::Admission a{other_than(rng, by), 1 + any_count(rng), any_count(rng), any_endpoint(rng), {}};
  for (std::uint32_t n = rng.below(kMaxPeers + 1); n > 0; --n) a.have.push_back(any_count(rng));
  a.spectator = rng.chance(0.2);
  return a;
}

/// `told`: when they were heard.
std::vector<wire::Seat> any_seats(Rng& rng, bool told = false) {
  std::vector<wire::Seat> seats;
  while (seats.empty())
    for (PeerId p = 0; p < kMaxPeers; ++p)
      if (rng.chance(0.2))
        seats.push_back({p, any_count(rng), any_count(rng), told ? rng.below(wire::kMostHeard + 1) : 0});
  return seats;
}

wire::Piece any_piece(Rng& rng) {
  wire::Piece p{1 + rng.next_u64() / 2, 0, 1 + rng.below(wire::kMaxPieces), {}};
  p.index = rng.below(p.count);
  p.bytes.resize(1 + rng.below(rng.chance(0.2) ? wire::kPieceBytes : 40));
  for (std::byte& b : p.bytes) b = static_cast<std::byte>(rng.below(256));
  return p;
}

wire::Fetched any_fetched(Rng& rng) {
  wire::Fetched f{static_cast<PeerId>(rng.below(kMaxPeers)), any_count(rng), {}};
  std::uint32_t index = any_count(rng);
  Tick tick = static_cast<Tick>(any_count(rng));
  for (std::uint32_t n = 1 + rng.below(3); n > 0; --n) {
    f.updates.push_back(any_bundle(rng, f.slot, index, tick, 1));
    index += 1 + rng.below(3);
    tick += 1 + static_cast<Tick>(rng.below(30));
  }
  return f;
}

wire::Whereabouts any_whereabouts(Rng& rng) {
  wire::Whereabouts w;
  w.in.resize(rng.below(4));
  w.seeks.resize(rng.below(wire::kMostRegions / 2));
  for (auto* column : {&w.in, &w.seeks})
    for (std::uint32_t& r : *column) r = 1 + rng.next_u32() / 2;
  return w;
}

}  // namespace

sync::Bundle any_crossing(Rng& rng, PeerId peer, std::uint32_t index, Tick tick) {
  Bundle b;
  b.peer = peer;
  b.index = index;
  b.tick = tick;
  if (rng.chance(0.3)) {
    b.going = rng.chance(0.5);
    return b;
  }
  for (std::uint32_t n = 1 + rng.below(sync::kMaxPassages); n > 0; --n) {
    sync::Passage& p = b.passages.emplace_back();
    p.kind = static_cast<sync::Passage::Kind>(rng.below(3));
    p.name = {1 + rng.next_u32() / 2, static_cast<std::uint16_t>(rng.below(65536))};
    p.crossings = 1 + any_count(rng);
    if (p.kind == sync::Passage::Kind::kBound) p.to = 1 + rng.next_u32() / 2;
    if (p.kind != sync::Passage::Kind::kIn) continue;
    p.owned = rng.chance(0.5);
    p.build = static_cast<std::uint8_t>(rng.below(3));
    p.state.position = {static_cast<float>(rng.uniform(-50, 50)), static_cast<float>(rng.uniform(-50, 50))};
    p.state.awake = rng.chance(0.5);
    if (p.state.awake) p.state.velocity = {static_cast<float>(rng.uniform(-5, 5)), 1};
  }
  return b;
}

wire::SessionMessage any_finding(Rng& rng) {
  const std::uint64_t nonce = 1 + rng.next_u64() / 2;
  const std::uint32_t about = 1 + rng.next_u32() / 2;
  if (rng.chance(0.5)) return wire::Ask{nonce, rng.next_u64(), about, any_whereabouts(rng), rng.next_u32()};
  wire::Tell t{nonce, rng.next_u64(), about, any_whereabouts(rng), rng.next_u32()};
  t.clock = rng.chance(0.5) ? static_cast<Micros>(rng.next_u32()) : 0;
  t.noted = rng.chance(0.5);
  for (std::uint32_t n = rng.below(5); n > 0; --n) t.known.push_back({any_endpoint(rng).place(), any_whereabouts(rng)});
  return t;
}

Bundle any_bundle(Rng& rng, PeerId peer, std::uint32_t index, Tick tick, int depth) {
  Bundle b;
  b.peer = peer;
  b.index = index;
  b.tick = tick;
  const std::uint32_t sort = rng.below(10);
  if (sort == 0) {
    (rng.chance(0.5) ? b.leave : b.spectates) = true;
  } else if (sort == 1) {
    b.admission = any_admission(rng, peer);
  } else if (sort == 2) {
    for (PeerId p = 0; p < kMaxPeers; ++p)
      if (p != peer && rng.chance(0.1)) b.removals.push_back({p, any_count(rng), any_count(rng)});
  } else if (sort == 3 && depth > 0) {
    const Tick before = static_cast<Tick>(rng.below(static_cast<std::uint32_t>(tick) + 1));
    b.passed_on.push_back(any_bundle(rng, other_than(rng, peer), any_count(rng), before, depth - 1));
  } else {
    tell_entities(rng, b);
  }
  if (b.bodies.size() <= sync::kMaxBodiesPerSigned && rng.chance(0.3))
    for (std::byte& byte : b.signature.emplace()) byte = static_cast<std::byte>(rng.below(256));
  return b;
}

sync::StatePacket any_packet(Rng& rng, PeerId sender) {
  sync::StatePacket p;
  p.seq = 1 + any_count(rng);
  p.incarnation = rng.chance(0.5) ? any_count(rng) : 0;
  p.to_incarnation = rng.chance(0.5) ? any_count(rng) : 0;
  p.mark_tick = 1000 + static_cast<Tick>(rng.below(100000));
  p.mark_count = 100 + any_count(rng);
  p.have = any_count(rng);
  p.have_beyond = rng.chance(0.5) ? rng.next_u32() : 0;
  p.seen_seq = any_count(rng);
  p.seen_age = rng.below(100);
  p.transit = static_cast<std::int32_t>(rng.below(20000)) - 10000;
  p.loss = rng.below(101);
  const std::uint32_t updates = rng.below(4);
  for (std::uint32_t i = 0; i < updates; ++i)
    p.updates.push_back(
        any_bundle(rng, sender, p.mark_count - updates + i, p.mark_tick - static_cast<Tick>((updates - i) * 3) + 3));
  if (rng.chance(0.5)) {
    p.check_tick = p.mark_tick - static_cast<Tick>(rng.below(900));
    p.check_hash = rng.next_u32() | 1U;
  }
  return p;
}

wire::MembershipMessage any_membership(Rng& rng, std::size_t kind) {
  const auto slot = static_cast<PeerId>(rng.below(kMaxPeers));
  switch (kind % kMembershipKinds) {
    case 0:
      return wire::Pull{1 + rng.next_u64() / 2, rng.below(wire::kMaxPieces), rng.next_u64(), rng.next_u64() | 1U};
    case 1:
      return any_piece(rng);
    case 2:
      return wire::Enter{1 + rng.next_u64() / 2};
    case 3:
      return wire::Poll{any_seats(rng), rng.chance(0.5), rng.below(wire::kMostPollNumber + 1)};
    case 4:
      return wire::Answer{any_seats(rng, true), rng.chance(0.5), static_cast<Tick>(any_count(rng) >> 1U),
                          rng.below(wire::kMostPollNumber + 1)};
    case 5:
      return wire::Fetch{slot, any_count(rng), any_count(rng)};
    case 6:
      return any_fetched(rng);
    case 7:
      return wire::Probe{any_count(rng), any_seats(rng), rng.chance(0.5), any_count(rng), rng.chance(0.5)};
    case 8: {
      wire::Reach reach{static_cast<Tick>(any_count(rng) >> 1U), {}};
      for (const wire::Seat& s : any_seats(rng))
        reach.heard.push_back({s.slot, rng.below(wire::kMostDelay + 1), rng.chance(0.3)});
      for (std::uint32_t n = rng.below(5); n > 0; --n)
        reach.at.push_back(
            padr::ipv4({192, 168, 0, static_cast<std::uint8_t>(n)}, static_cast<std::uint16_t>(1 + slot)));
      return reach;
    }
    default: {
      Endpoint at = padr::ipv4({10, 0, 0, static_cast<std::uint8_t>(slot)}, static_cast<std::uint16_t>(1 + slot));
      if (rng.chance(0.5)) at.key.fill(static_cast<std::uint8_t>(1 + slot));
      return wire::Newcomer{at};
    }
  }
}

Bundle largest_bundle(int passings, bool is_signed) {
  constexpr Tick kLate = (1 << 28) - 1;
  Bundle b;
  b.peer = 63;
  b.index = kSome - 1;
  b.tick = kLate;
  if (is_signed) b.signature.emplace().fill(std::byte{0xA5});
  if (passings > 0) {
    b.passed_on.push_back(largest_bundle(passings - 1, is_signed));
    b.passed_on[0].peer = 30;
    return b;
  }
  b.avatar = sync::AvatarUpdate{};
  b.avatar->model = Model::kInput;
  b.avatar->position.x = 0.1F;  // not to be told in steps
  const std::size_t most = is_signed ? sync::kMaxBodiesPerSigned : sync::kMaxBodiesPerBundle;
  for (std::size_t i = 0; i < most; ++i) {
    BodyUpdate u;
    u.body = static_cast<EntityId>(kNoEntity - most + i);
    u.has_state = true;
    u.epoch = kSome;
    u.claimed = 0;
    b.bodies.push_back(u);
  }
  return b;
}

Played::Played(std::uint64_t seed, Tick ticks)
    : scene_(busy_scene(seed, 40, true)), world_(scene_, {kSlots, 3, 0, true, true, {}}, {}) {
  write_log(seed);
  play(ticks);
}

void Played::write_log(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<std::uint32_t> next(kSlots, 0);
  const auto coordinate = [&rng](double hi) { return static_cast<float>(rng.uniform(0.5, hi)); };
  for (Tick t = 1; t < kLogTicks; ++t) {
    for (PeerId p = 0; p < kSlots; ++p) {
      const bool order = p == 0 && (t == kComesIn || t == kIsOut);
      const bool there = (p != 3 || t > kComesIn) && (p != 2 || t < kIsOut - 20);
      if (!there || (!order && !rng.chance(0.2))) continue;
      Bundle b;
      b.peer = p;
      b.index = next[p]++;
      b.tick = t;
      if (order && t == kComesIn) {
        b.admission = sync::Admission{3, 1, 0, any_endpoint(rng), next};
      } else if (order) {
        b.removals.push_back({2, 0, next[2]});
      } else {
        b.avatar = sync::AvatarUpdate{};
        b.avatar->model = static_cast<Model>(rng.below(4));
        b.avatar->position = {coordinate(9.5), coordinate(7.5)};
        b.avatar->velocity = {coordinate(3), -coordinate(3)};
        if (b.avatar->model >= Model::kSecond) b.avatar->control = {coordinate(9.5), coordinate(7.5)};
        BodyUpdate u = any_body(rng, static_cast<EntityId>(rng.below(12)), t);
        u.epoch = 1 + rng.below(4);
        u.state.position = {coordinate(9.5), coordinate(7.5)};
        b.bodies.push_back(u);
      }
      log_.push_back(std::move(b));
    }
  }
}

void Played::feed(sync::AgreedWorld& world, Tick t) const {
  std::vector<std::uint32_t> counts(kSlots, 0);
  for (const Bundle& b : log_) {
    const Tick mark = t - kDelay;
    if (b.tick <= mark) counts[b.peer] = b.index + 1;
    if (b.tick > t) continue;
    world.insert(b);
    if (b.tick != t) continue;
    if (b.admission) world.open(b.admission->slot, t);
    for (const sync::Removal& r : b.removals) world.close(r.slot, r.count);
  }
  for (PeerId p = 0; p < kSlots; ++p)
    if (!world.log().closed(p)) world.mark(p, t - kDelay, counts[p]);
}

void Played::play(sync::AgreedWorld& world, Tick tick) const {
  while (world.now() < tick) {
    world.step();
    feed(world, world.now());
    world.catch_up();
    world.confirm();
  }
}

sync::Transfer Played::transfer() const {
  sync::Transfer t;
  t.state = world_.confirmed();
  t.tail = world_.log().since(t.state.tick);
  for (PeerId p = 0; p < kSlots; ++p) {
    Rng rng(p + 1U);
    const bool told = p != 0 && t.state.members[p].present;
    t.slots.push_back({world_.log().have(p), told ? any_endpoint(rng) : Endpoint{}, told ? 10 * p : 0});
    t.have.push_back(world_.log().have(p));
  }
  Rng rng(0);
  t.gone = {{any_endpoint(rng), 3, 200}, {any_endpoint(rng), 200, 200}};
  if (t.tail.size() > 1) t.proofs.push_back({any_endpoint(rng).key, 7, t.tail[0], t.tail[1]});
  for (const Bundle& b : t.tail) t.slots[b.peer].first = std::min(t.slots[b.peer].first, b.index);
  return t;
}

}  // namespace padr::test
